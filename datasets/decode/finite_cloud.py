"""What every decoder of clouds ends with."""

from typing import Any

import numpy as np
from jaxtyping import Float32, UInt16

from navtool.base.note import Note
from navtool.datasets.decode.header import Head
from navtool.datasets.decode.messages import PointCloud
from navtool.pipeline.arrays import Array

_MOST_M = 1e9


def finite_cloud(
    head: Head,
    columns: Float32[Array, "3 n"],
    intensity: Float32[Array, " n"] | None,
    ring: UInt16[Array, " n"] | None,
    time_s: Float32[Array, " n"] | None,
    notes: tuple[Note, ...] = (),
) -> PointCloud:
    """The cloud without its points of a NaN, infinite or immeasurable coordinate; the others keep their order.

    What is left out is counted. Coordinates beyond a million kilometres are damage, and overflow as soon as they are
    moved into another frame.

    Args:
        notes: What is odd about the message that it came in.
        columns: x, y and z one after the other: what works on clouds goes through one coordinate after the other.
    """
    x, y, z = columns
    finite = (np.abs(x) <= _MOST_M) & (np.abs(y) <= _MOST_M) & (np.abs(z) <= _MOST_M)
    kept: Any = slice(None) if finite.all() else finite
    return PointCloud(
        **head._asdict(),
        xyz=columns[:, kept].T,
        intensity=None if intensity is None else intensity[kept],
        ring=None if ring is None else ring[kept],
        time_s=None if time_s is None else time_s[kept],
        dropped_nonfinite=finite.size - int(np.count_nonzero(finite)),
        notes=notes,
    )
