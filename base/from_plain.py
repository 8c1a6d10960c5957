"""Typed configuration out of plain mappings, such as a parsed YAML or JSON file: the inverse of ``lineage.plain``."""

import dataclasses
import difflib
import types
from collections.abc import Mapping, Sequence
from enum import Enum
from pathlib import Path
from typing import Union, get_args, get_origin, get_type_hints

from navtool.base.errors import DatasetsError


def from_plain[T](cls: type[T], value: object, *, where: str | Path) -> T:
    """An instance of the dataclass ``cls``, checked strictly: no unknown key, no other type, no silent conversion.

    Whole numbers are taken where a float is wanted, and enums by the names of their members; nothing else is
    converted. Every fault of the mapping is named in one error.

    Args:
        cls: The dataclass to build; its fields may nest dataclasses, lists, dicts, enums and optional values.
        value: The parsed content.
        where: The file that the content comes from, for messages.

    Raises:
        DatasetsError: If a key is unknown or missing, a value has another type, or a check of the dataclass fails.
    """
    faults: list[str] = []
    built = _dataclass(cls, value, "", faults)
    if faults or not isinstance(built, cls):
        raise DatasetsError("; ".join(faults), where=where, cure="correct the named keys; see the documented fields")
    return built


def did_you_mean(word: str, known: Sequence[str]) -> str:
    """A hint such as `` (did you mean 'odometry'?)``; empty where no known word is close."""
    close = difflib.get_close_matches(word, known, n=1)
    return f" (did you mean {close[0]!r}?)" if close else ""


def _dataclass(cls: type, value: object, path: str, faults: list[str]) -> object:
    if not isinstance(value, Mapping):
        faults.append(f"{path or 'the file'}: wanted keys and values, got {_kind(value)}")
        return None
    fields = {field.name: field for field in dataclasses.fields(cls)}
    hints = get_type_hints(cls)
    before = len(faults)
    arguments: dict[str, object] = {}
    for key, entry in value.items():
        place = f"{path}.{key}" if path else str(key)
        if key not in fields:
            known = sorted(fields)
            faults.append(f"unknown key {place!r}{did_you_mean(str(key), known)}, known are {', '.join(known)}")
            continue
        arguments[str(key)] = _value(hints[str(key)], entry, place, faults)
    faults.extend(
        f"missing key {f'{path}.{name}' if path else name!r}"
        for name, field in fields.items()
        if name not in value and field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING
    )
    if len(faults) > before:
        return None
    try:
        return cls(**arguments)
    except (DatasetsError, ValueError) as error:
        text = f"{error.where}: {error.what}" if isinstance(error, DatasetsError) else str(error)
        hint = f" ({error.cure})" if isinstance(error, DatasetsError) and error.cure else ""
        faults.append(f"{path}: {text}{hint}" if path else f"{text}{hint}")
        return None


def _value(hint: object, value: object, path: str, faults: list[str]) -> object:
    origin, arguments = get_origin(hint), get_args(hint)
    if origin in (Union, types.UnionType):
        inner = next(argument for argument in arguments if argument is not types.NoneType)
        return None if value is None else _value(inner, value, path, faults)
    if origin is list and isinstance(value, list):
        return [_value(arguments[0], entry, f"{path}[{i}]", faults) for i, entry in enumerate(value)]
    if origin is dict and isinstance(value, Mapping):
        return {str(key): _value(arguments[1], entry, f"{path}.{key}", faults) for key, entry in value.items()}
    if origin in (list, dict):
        faults.append(f"{path}: wanted {'a list' if origin is list else 'keys and values'}, got {_kind(value)}")
        return None
    if not isinstance(hint, type):
        raise TypeError(f"{path}: fields of type {hint} are not supported")
    return (
        _dataclass(hint, value, path, faults) if dataclasses.is_dataclass(hint) else _scalar(hint, value, path, faults)
    )


def _scalar(hint: type, value: object, path: str, faults: list[str]) -> object:
    if issubclass(hint, Enum):
        if isinstance(value, str) and value in hint.__members__:
            return hint[value]
        faults.append(f"{path}: {value!r} is none of {', '.join(hint.__members__)}")
        return None
    if hint is float and isinstance(value, int) and not isinstance(value, bool):
        return float(value)
    if isinstance(value, hint) and (hint is bool or not isinstance(value, bool)):
        return value
    faults.append(f"{path}: wanted {_NAMES.get(hint, hint.__name__)}, got {_kind(value)}")
    return None


_NAMES = {float: "a number", int: "a whole number", str: "text", bool: "true or false"}


def _kind(value: object) -> str:
    if value is None:
        return "nothing"
    if isinstance(value, str):
        return f"the text {value!r}"
    if isinstance(value, Mapping):
        return "keys and values"
    if isinstance(value, list):
        return "a list"
    return repr(value)
