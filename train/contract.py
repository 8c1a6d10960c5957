"""What a model's artefact takes and gives."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

from torch import Tensor


@dataclass(frozen=True, slots=True)
class TensorSpec:
    """One input or output."""

    name: str
    shape: tuple[int | str, ...]
    """Sizes; a name such as ``batch`` where any size >= 1 goes."""
    dtype: str
    """uint8, int64 or float32."""
    unit: str
    """SI, or 1."""
    range: tuple[float, float] | None
    """Smallest and largest value; None where there is no bound."""
    frame: str
    """Frame and order of the values."""

    def __post_init__(self) -> None:
        if any(isinstance(size, int) and size < 1 for size in self.shape):
            raise ValueError(f"shape {list(self.shape)}: a size is at least 1")


@dataclass(frozen=True, slots=True)
class Contract:
    """Inputs and outputs of an artefact; each begins with the batch axis."""

    inputs: tuple[TensorSpec, ...]
    """Arguments of forward, in order."""
    outputs: tuple[TensorSpec, ...]
    """What forward returns: a tensor, or a tuple of as many as are named here."""
    methods: tuple[str, ...] = ("forward",)
    """What a caller may call, forward included."""


class OnboardNetwork(Protocol):
    """A network as an artefact holds it."""

    def __call__(self, *inputs: Tensor) -> Any:
        """What forward returns."""

    def __getattr__(self, name: str) -> Callable[..., Tensor]:
        """One of the contract's methods."""


class Law(NamedTuple):
    """Two ways to the same result, which verification compares."""

    gap: Callable[[OnboardNetwork, tuple[Tensor, ...]], float]
    """Largest difference between the two, from the golden inputs."""
    between: str
    """What is compared, such as ``between candidates together and alone``."""


type Timed = Callable[[OnboardNetwork, tuple[Tensor, ...]], object]
"""Something whose duration verification reports, from the inputs of one sample."""


def forward(network: OnboardNetwork, inputs: tuple[Tensor, ...]) -> object:
    """The network's answer."""
    return network(*inputs)
