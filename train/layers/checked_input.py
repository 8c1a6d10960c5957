"""Refusing a tensor that is not what an artefact declares."""

import torch
from torch import Tensor


def check_input(tensor: Tensor, name: str, dtype: str, sizes: list[int]) -> None:
    """Do nothing where a tensor has this type and shape; scriptable.

    Args:
        tensor: An input of the artefact.
        name: Of the input.
        dtype: uint8, int64 or float32.
        sizes: Of its axes; -1 where any size goes.

    Raises:
        ValueError: It is another one; the message says what was wanted.
    """
    fits = has_type(tensor, dtype) and tensor.dim() == len(sizes)
    if fits:
        for axis, size in enumerate(sizes):
            fits = fits and (size == -1 or tensor.size(axis) == size)
    if not fits:
        raise ValueError(f"{name} must be {dtype} {sizes}, -1 for any size; it has the shape {tensor.size()}")


def has_type(tensor: Tensor, dtype: str) -> bool:
    """Whether a tensor is uint8, int64 or float32, as ``dtype`` says; scriptable."""
    if dtype == "uint8":
        return tensor.dtype == torch.uint8
    if dtype == "int64":
        return tensor.dtype == torch.int64
    return dtype == "float32" and tensor.dtype == torch.float32
