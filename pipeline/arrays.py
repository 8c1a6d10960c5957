"""The array type inside the shape annotations."""

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[Any]
else:
    # NDArray[Any] is no class at run time from NumPy 2.5 on, and jaxtyping takes only classes.
    Array = np.ndarray
"""A NumPy array of any dtype, for `Float64[Array, "n 3"]`: the annotation around it names dtype and shape."""
