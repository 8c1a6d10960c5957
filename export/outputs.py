"""A network's outputs as tensors, and how far two of them lie apart."""

from collections.abc import Callable, Sequence

from torch import Tensor


def outputs_of(network: Callable[..., object], inputs: Sequence[Tensor]) -> tuple[Tensor, ...]:
    """What the network returns, a single tensor as a tuple of one.

    Raises:
        TypeError: It returns something else.
    """
    output = network(*inputs)
    tensors = output if isinstance(output, tuple) else (output,)
    for entry in tensors:
        if not isinstance(entry, Tensor):
            raise TypeError(f"the model returns a {type(entry).__name__}, not a tensor")
    return tensors


def largest_gap(ones: Sequence[Tensor], others: Sequence[Tensor]) -> float:
    """The largest difference between outputs.

    Raises:
        ValueError: Their number or shapes differ.
    """
    shapes = [[list(tensor.shape) for tensor in side] for side in (ones, others)]
    if shapes[0] != shapes[1]:
        raise ValueError(f"the output has shape {shapes[0]}, wanted {shapes[1]}")
    return max(float((one.double() - other.double()).abs().max()) for one, other in zip(ones, others, strict=True))
