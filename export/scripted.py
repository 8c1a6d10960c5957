"""TorchScript: the network as the onboard runtime loads it from C++ or Python. Only this file names ``torch.jit``."""

import io
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import torch
from torch import nn

type Scripted = torch.jit.ScriptModule
"""A compiled network."""


def script(module: nn.Module, methods: Sequence[str]) -> Scripted:
    """The network compiled in evaluation mode and frozen: its weights are constants, and dropout is gone.

    Args:
        module: As its kind of model brings it on board.
        methods: What stays callable, forward included.
    """
    with _deprecation_known():
        compiled = torch.jit.script(module.eval())
        frozen: Scripted = torch.jit.freeze(compiled, [name for name in methods if name != "forward"])
        return frozen


def save_scripted(model: Scripted, path: Path) -> None:
    """Write a compiled network."""
    with _deprecation_known():
        torch.jit.save(model, str(path))


def load_scripted(content: bytes, device: torch.device) -> Scripted:
    """A compiled network from the bytes of its file.

    Loading runs TorchScript, which has no access to files or processes, but which can loop or fill memory: load only
    bytes whose hash was checked against a manifest of known origin.

    Raises:
        RuntimeError: The bytes are no TorchScript archive.
    """
    with _deprecation_known():
        loaded: Scripted = torch.jit.load(  # type: ignore[no-untyped-call]  # torch leaves it untyped
            io.BytesIO(content), map_location=device
        )
        return loaded


def told_by_script(error: Exception) -> str:
    """What TorchScript says went wrong: of its trace the last line, which holds the message."""
    lines = [line.strip() for line in str(error).split("\n") if line.strip()]
    if not lines:
        return type(error).__name__
    return lines[-1] if isinstance(error, torch.jit.Error) else lines[0]


SCRIPT_ERRORS = (torch.jit.Error, RuntimeError)
"""What a compiled network raises on inputs that it refuses."""


@contextmanager
def _deprecation_known() -> Iterator[None]:
    """The runtime requires TorchScript, so its deprecation is no news."""
    with warnings.catch_warnings():
        for name in ("script", "freeze", "save", "load"):
            # a DeprecationWarning in some versions of torch, a FutureWarning in others
            warnings.filterwarnings("ignore", message=rf"`torch\.jit\.{name}` is deprecated")
        yield
