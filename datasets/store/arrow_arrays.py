"""NumPy arrays and texts as Arrow arrays, their bytes shared where they can be.

``pyarrow.array`` gives the same, but imports pandas where that is installed, which takes half a second.
"""

from collections.abc import Sequence

import numpy as np
import pyarrow as pa
from jaxtyping import Shaped

from navtool.pipeline.arrays import Array


def number_array(values: Shaped[Array, " n"]) -> pa.Array:
    """Numbers or truth values without nulls."""
    packed = np.packbits(values, bitorder="little") if values.dtype == np.bool_ else np.ascontiguousarray(values)
    return pa.Array.from_buffers(pa.from_numpy_dtype(values.dtype), values.size, [None, pa.py_buffer(packed)])


def text_array(values: Sequence[str]) -> pa.Array:
    """Texts without nulls."""
    encoded = [value.encode() for value in values]
    ends = np.cumsum([0, *map(len, encoded)], dtype=np.int32)
    return pa.Array.from_buffers(pa.string(), len(encoded), [None, pa.py_buffer(ends), pa.py_buffer(b"".join(encoded))])


def nested_array(values: Shaped[Array, " n *shape"]) -> pa.Array:
    """One entry a row: a number, a list of numbers, a list of lists of them."""
    inner = number_array(values.reshape(-1))
    for axis in range(values.ndim - 1, 0, -1):
        lists, size = int(np.prod(values.shape[:axis])), values.shape[axis]
        inner = pa.ListArray.from_arrays(number_array(np.arange(lists + 1, dtype=np.int32) * size), inner)
    return inner
