import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from beartype import beartype
from beartype.roar import BeartypeCallHintViolation
from jaxtyping import Float32
from shape_checks import checked

from navtool.pipeline.arrays import Array

ROOT = Path(__file__).parents[2]


def test_the_array_type_is_a_class_as_jaxtyping_wants_it() -> None:
    assert issubclass(Array, np.ndarray)
    points: Any = Float32[Array, "n 3"]
    assert isinstance(np.zeros((2, 3), np.float32), points)
    assert not isinstance(np.zeros((2, 4), np.float32), points)


def test_shapes_stand_around_a_class() -> None:
    """``NDArray[...]`` is none from NumPy 2.5 on: a module that wraps it in a shape cannot be imported there."""
    folders = [folder.parent for folder in ROOT.glob("*/*.py") if folder.parent.name not in ("build", "tests")]
    sources = [source for folder in dict.fromkeys(folders) for source in folder.rglob("*.py")]
    assert len(sources) > 300
    wrapped = re.compile(r"\b(Float|Int|UInt|Bool|Shaped|Num|Real)[0-9]*\[NDArray")
    assert [file.name for file in sources if wrapped.search(file.read_text(encoding="utf-8"))] == []


@checked(typechecker=beartype)
def _product(left: Float32[Array, "n m"], right: Float32[Array, "m k"]) -> Float32[Array, "n k"]:
    return left @ right if len(left) < 5 else left


@checked(typechecker=beartype)
def _repeated(row: Float32[Array, " n"], count: int) -> Float32[Array, "{count} n"]:
    return np.stack([row] * max(count, 2))


@checked(typechecker=beartype)
def _product_of_product(matrix: Float32[Array, "n m"]) -> Float32[Array, "n 9"]:
    product: Array = _product(_product(matrix, _ones(matrix.shape[1], 7)), _ones(7, 9))
    return product


def _ones(*shape: int) -> Any:
    return np.ones(shape, np.float32)


def test_a_letter_of_a_shape_means_one_size_within_a_call_and_any_in_the_next() -> None:
    assert _product(_ones(2, 3), _ones(3, 4)).shape == (2, 4)
    assert _product(_ones(3, 2), _ones(2, 5)).shape == (3, 5)
    assert _repeated(_ones(4), 3).shape == (3, 4)
    assert _product_of_product(_ones(3, 2)).shape == (3, 9)
    unfit: list[tuple[Any, ...]] = [
        (_product, _ones(2, 3), _ones(4, 4)),
        (_product, _ones(5, 3), _ones(3, 4)),  # it returns another shape
        (_product, _ones(2, 3).astype(float), _ones(3, 4)),
        (_product, _ones(2), _ones(3, 4)),
        (_repeated, _ones(4), 1),  # it returns two rows
        (_repeated, _ones(4), 2.0),
    ]
    for function, *arguments in unfit:
        with pytest.raises(BeartypeCallHintViolation):
            function(*arguments)
