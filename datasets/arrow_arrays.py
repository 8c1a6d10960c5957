"""NumPy arrays as Arrow arrays, their bytes shared and nothing else imported for it."""

import numpy as np
import pyarrow as pa
from jaxtyping import Shaped

from navtool.pipeline.arrays import Array


def number_array(values: Shaped[Array, " n"]) -> pa.Array:
    """Numbers or truth values without nulls.

    ``pyarrow.array`` gives the same, but imports pandas where that is installed, which takes half a second.
    """
    packed = np.packbits(values, bitorder="little") if values.dtype == np.bool_ else np.ascontiguousarray(values)
    return pa.Array.from_buffers(pa.from_numpy_dtype(values.dtype), values.size, [None, pa.py_buffer(packed)])
