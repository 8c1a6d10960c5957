"""TorchScript: the network as the onboard runtime loads it from C++ or Python. Only this file names ``torch.jit``."""

import io
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import torch
from torch import Tensor, nn

from navtool.export.contract import METHODS
from navtool.train.graspe.graspe import Graspe


class CheckedGraspe(nn.Module):
    """A network that refuses inputs of another type or shape, with a message, instead of computing nonsense."""

    def __init__(self, model: Graspe, height: int, width: int, history: int) -> None:
        super().__init__()
        self.model = model
        self.height = height
        self.width = width
        self.history = history

    def forward(
        self, image: Tensor, points: Tensor, count: Tensor, velocity: Tensor, trajectory: Tensor, reliability: Tensor
    ) -> Tensor:
        """Return the probability of success at each step of one trajectory per sample, [B, T]."""
        if trajectory.dim() != 4:
            raise ValueError("trajectory must be [batch, 1, height, width]")
        features = self.encode_sensors(image, points, count, velocity)
        return self.score_candidates(features, trajectory.unsqueeze(1), reliability).squeeze(1)

    def encode_sensors(self, image: Tensor, points: Tensor, count: Tensor, velocity: Tensor) -> Tensor:
        """Return what all candidates of a tick share, [B, F]."""
        if image.dtype != torch.uint8 or image.dim() != 4:
            raise ValueError("image must be uint8 [batch, 3, height, width]")
        batch = image.shape[0]
        if batch < 1 or image.shape[1] != 3 or image.shape[2] != self.height or image.shape[3] != self.width:
            raise ValueError("image has another size than the network was trained on")
        if points.dtype != torch.float32 or points.dim() != 3 or points.shape[0] != batch or points.shape[2] != 3:
            raise ValueError("points must be float32 [batch, points, 3]")
        if count.dtype != torch.int64 or count.dim() != 1 or count.shape[0] != batch:
            raise ValueError("count must be int64 [batch]")
        if int(count.min()) < 0 or int(count.max()) > points.shape[1]:
            raise ValueError("count must lie between 0 and the number of points")
        if velocity.dtype != torch.float32 or velocity.dim() != 3 or velocity.shape[0] != batch:
            raise ValueError("velocity must be float32 [batch, history, 2]")
        if velocity.shape[1] != self.history or velocity.shape[2] != 2:
            raise ValueError("velocity has another history than the network was trained on")
        return self.model.encode_sensors(image, points, count, velocity)

    def score_candidates(self, features: Tensor, trajectory: Tensor, reliability: Tensor) -> Tensor:
        """Return the probability of success at each step of each candidate, [B, K, T]."""
        batch = features.shape[0]
        if trajectory.dtype != torch.uint8 or trajectory.dim() != 5 or trajectory.shape[0] != batch:
            raise ValueError("trajectory must be uint8 [batch, candidates, 1, height, width]")
        if trajectory.shape[2] != 1 or trajectory.shape[3] != self.height or trajectory.shape[4] != self.width:
            raise ValueError("trajectory has another size than the network was trained on")
        if reliability.dtype != torch.float32 or reliability.dim() != 2 or reliability.shape[0] != batch:
            raise ValueError("reliability must be float32 [batch, 2]")
        if reliability.shape[1] != 2:
            raise ValueError("reliability must be float32 [batch, 2]")
        return self.model.score_candidates(features, trajectory, reliability)


def script(model: Graspe, *, height: int, width: int, history: int) -> torch.jit.ScriptModule:
    """The network compiled in evaluation mode and frozen: its weights are constants, and dropout is gone."""
    with _deprecation_known():
        compiled = torch.jit.script(CheckedGraspe(model, height, width, history).eval())
        frozen: torch.jit.ScriptModule = torch.jit.freeze(compiled, [name for name in METHODS if name != "forward"])
        return frozen


def save_scripted(model: torch.jit.ScriptModule, path: Path) -> None:
    """Write a compiled network."""
    with _deprecation_known():
        torch.jit.save(model, str(path))


def load_scripted(content: bytes, device: torch.device) -> torch.jit.ScriptModule:
    """A compiled network from the bytes of its file.

    Loading runs TorchScript, which has no access to files or processes, but which can loop or fill memory: load only
    bytes whose hash was checked against a manifest of known origin.

    Raises:
        RuntimeError: The bytes are no TorchScript archive.
    """
    with _deprecation_known():
        loaded: torch.jit.ScriptModule = torch.jit.load(  # type: ignore[no-untyped-call]  # torch leaves it untyped
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
            warnings.filterwarnings(
                "ignore", message=rf"`torch\.jit\.{name}` is deprecated", category=DeprecationWarning
            )
        yield
