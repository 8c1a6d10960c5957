"""Which decoder reads which message type."""

from collections.abc import Callable
from typing import Any

from navtool.datasets.decode.messages import Decoded

type Decoder = Callable[[Any], Decoded]

DECODERS: dict[str, Decoder] = {}
