"""Checks of types and array shapes as the code runs, at the cost that each function's annotations need."""

import inspect
import typing
from collections.abc import Callable, Sequence
from types import FunctionType
from typing import Any

import jaxtyping
from beartype import beartype

_jaxtyped: Any = jaxtyping.jaxtyped


def check_while_running(packages: Sequence[str]) -> None:
    """Let beartype check every signature of the packages, and jaxtyping those that name arrays; call before any import.

    jaxtyping's own hook binds the arguments of every call by name, also where no array is among them: half of the time
    of an ingest.
    """
    jaxtyping.jaxtyped = _checked  # type: ignore[assignment]
    jaxtyping.install_import_hook(packages, "beartype.beartype")


def _checked(*, typechecker: Callable[..., Any]) -> Callable[[Any], Any]:
    def decorate(found: Any) -> Any:
        hints = list(inspect.get_annotations(found).values()) if isinstance(found, FunctionType) else []
        if typing.Self in hints:  # beartype knows what it is only where it decorates the whole class
            return found
        # beartype wants to see what a generator's hint is an alias of
        if isinstance(found, FunctionType) and not inspect.isgeneratorfunction(found) and not _names_arrays(hints):
            return beartype(found)
        return _jaxtyped(found, typechecker=typechecker)

    return decorate


def _names_arrays(annotation: object) -> bool:
    """Whether an array's shape is anywhere in an annotation, or may be: one in quotes is not looked into."""
    if isinstance(annotation, list | tuple):
        return any(map(_names_arrays, annotation))
    if isinstance(annotation, typing.TypeAliasType):
        return _names_arrays(annotation.__value__)
    if isinstance(annotation, str | typing.ForwardRef):
        return True
    if isinstance(annotation, type) and issubclass(annotation, jaxtyping.AbstractArray):
        return True
    return _names_arrays(typing.get_args(annotation))
