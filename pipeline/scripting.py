"""Mark the functions that TorchScript compiles."""

import typing
from collections.abc import Callable


def no_type_check[F: Callable[..., object]](function: F) -> F:
    """Keep run-time type checkers off a function that TorchScript compiles from its source.

    Tests wrap every function of this package to check array shapes; a wrapper has other globals than the function, and
    TorchScript would look names up there. The import hook of jaxtyping leaves out what a ``no_type_check`` decorates;
    unlike the one in ``typing``, this one leaves static checking on.
    """
    return typing.no_type_check(function)
