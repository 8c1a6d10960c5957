"""Checks of types and array shapes as the code runs, at the cost that each function's annotations need."""

import functools
import inspect
import typing
from collections.abc import Callable, Iterator, Sequence
from types import FunctionType
from typing import Any

import jaxtyping
from beartype import beartype

QUOTED = "in quotes"
_jaxtyped: Any = jaxtyping.jaxtyped


def check_while_running(packages: Sequence[str]) -> None:
    """Let beartype check every signature of the packages, and jaxtyping those that name arrays; call before any import.

    jaxtyping's own hook binds the arguments of every call by name, also where no array is among them, and checks them
    again beside the result: half of the time of an ingest or of a simulated walk.
    """
    jaxtyping.jaxtyped = checked  # type: ignore[assignment]
    jaxtyping.install_import_hook(packages, "beartype.beartype")


def checked(*, typechecker: Callable[..., Any]) -> Callable[[Any], Any]:
    """What stands for jaxtyping's decorator: the function or class that checks its annotations in each call."""

    def decorate(found: Any) -> Any:
        hints = list(inspect.get_annotations(found).values()) if isinstance(found, FunctionType) else []
        if typing.Self in hints:  # beartype knows what it is only where it decorates the whole class
            return found
        shapes = list(_shapes(hints))
        # beartype wants to see what a generator's hint is an alias of, and what is in quotes
        if not isinstance(found, FunctionType) or inspect.isgeneratorfunction(found) or QUOTED in shapes:
            return _jaxtyped(found, typechecker=typechecker)
        if any("{" in shape for shape in shapes):  # such a size is the value of an argument, to be found by its name
            return _jaxtyped(beartype(found), typechecker=None)
        return _with_sizes_of_its_own(beartype(found)) if shapes else beartype(found)

    return decorate


def _with_sizes_of_its_own(function: Callable[..., Any]) -> Callable[..., Any]:
    """The function, in each call of which a letter of a shape means one size."""

    @functools.wraps(function)
    def call(*arguments: Any, **named: Any) -> Any:
        with _jaxtyped("context"):
            return function(*arguments, **named)

    return call


def _shapes(annotation: object) -> Iterator[str]:
    """Every array's shape in an annotation; `QUOTED` for what is in quotes, which is not looked into."""
    if isinstance(annotation, list | tuple):
        for part in annotation:
            yield from _shapes(part)
    elif isinstance(annotation, typing.TypeAliasType):
        yield from _shapes(annotation.__value__)
    elif isinstance(annotation, str | typing.ForwardRef):
        yield QUOTED
    elif isinstance(annotation, type) and issubclass(annotation, jaxtyping.AbstractArray):
        yield annotation.dim_str
    else:
        yield from _shapes(typing.get_args(annotation))
