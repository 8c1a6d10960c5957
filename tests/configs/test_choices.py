"""Every setting that takes one of a few values is a text that is called as it is written."""

import dataclasses
from collections.abc import Iterator
from enum import Enum, StrEnum
from pkgutil import resolve_name
from typing import get_args, get_type_hints

import pytest

from navtool.configs.schema import SCHEMAS
from navtool.train.models import MODELS

ROOTS = (
    *(resolve_name(schema.dataclass) for schemas in SCHEMAS.values() for schema in schemas),
    *(kind.config for kind in MODELS.values()),
)


def types_in(hint: object) -> Iterator[type]:
    """The classes that a type hint names, those inside of lists and unions included."""
    if isinstance(hint, type) and not get_args(hint):
        yield hint
    for argument in get_args(hint):
        yield from types_in(argument)


def choices_of(roots: tuple[type, ...]) -> set[type[Enum]]:
    found: set[type[Enum]] = set()
    seen, ahead = set(roots), list(roots)
    while ahead:
        for hint in get_type_hints(ahead.pop()).values():
            for kind in types_in(hint):
                if issubclass(kind, Enum):
                    found.add(kind)
                elif dataclasses.is_dataclass(kind) and kind not in seen:
                    seen.add(kind)
                    ahead.append(kind)
    return found


CHOICES = sorted(choices_of(ROOTS), key=lambda kind: f"{kind.__module__}.{kind.__qualname__}")


def test_choices_are_found_wherever_they_stand() -> None:
    names = {kind.__name__ for kind in CHOICES}
    assert {"Merge", "Clock", "Method", "Device", "GroupBy", "RobotKind", "Partition", "Inflation"} <= names


@pytest.mark.parametrize("kind", CHOICES, ids=lambda kind: f"{kind.__module__}.{kind.__qualname__}")
def test_a_choice_is_a_text_called_as_it_is_written(kind: type[Enum]) -> None:
    assert issubclass(kind, StrEnum)
    assert [choice.name for choice in kind] == [choice.value for choice in kind]
