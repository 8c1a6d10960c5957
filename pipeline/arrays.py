"""The array type inside the shape annotations."""

from typing import Any

from numpy.typing import NDArray

Array = NDArray[Any]
"""A NumPy array of any dtype, for `Float64[Array, "n 3"]`: the annotation around it names dtype and shape."""
