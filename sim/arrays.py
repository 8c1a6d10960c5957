"""The array type that the shapes in this package's signatures are written about."""

from typing import Any

from numpy.typing import NDArray

Array = NDArray[Any]
"""A numpy array of any element type; jaxtyping states element type and shape, as in ``Float32[Array, "3 n"]``."""
