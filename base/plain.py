"""Typed values as plain ones, as JSON and YAML know them; ``from_plain`` leads back."""

import dataclasses
from collections.abc import Mapping, Sequence
from enum import Enum
from pathlib import Path
from typing import Any, ClassVar, Protocol, runtime_checkable

import numpy as np

from navtool.base.note import Note

LEFT_OUT_WHILE_EMPTY = {"left_out_while_empty": True}
"""Metadata of a dataclass's field that is not written while it is empty; files then read as before there was such."""


@runtime_checkable
class Dataclass(Protocol):
    """An instance of any dataclass."""

    __dataclass_fields__: ClassVar[dict[str, dataclasses.Field[Any]]]


def plain(value: object) -> object:
    """The value as what JSON knows: dataclasses become objects, enums names, arrays lists, paths and notes text."""
    if isinstance(value, Note):
        return value.text
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return plain_fields(value)
    if isinstance(value, Enum):
        return value.name
    if isinstance(value, Mapping):
        return {str(key): plain(entry) for key, entry in value.items()}
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, Path):
        return value.as_posix()
    if isinstance(value, Sequence) and not isinstance(value, str | bytes):
        return [plain(entry) for entry in value]
    return value


def plain_fields(value: Dataclass) -> dict[str, Any]:
    """The fields of a dataclass, in their order, as plain values."""
    entries = ((field, getattr(value, field.name)) for field in dataclasses.fields(value))
    return {
        field.name: plain(entry)
        for field, entry in entries
        if not (field.metadata.get("left_out_while_empty") and not entry)
    }


def flatten(value: object, prefix: str = "") -> dict[str, object]:
    """The leaves of a nested value by their dotted keys, such as ``trainer.epochs``; a list is a leaf.

    Args:
        value: A dataclass, or a mapping.
        prefix: Key of the value itself.
    """
    content = plain(value)
    if not isinstance(content, dict):
        return {prefix: content}
    leaves: dict[str, object] = {}
    for key, entry in content.items():
        leaves |= flatten(entry, f"{prefix}.{key}" if prefix else key)
    return leaves
