"""Typed configuration out of plain mappings, such as a parsed YAML or JSON file: the inverse of ``plain``."""

import dataclasses
import difflib
import types
from collections.abc import Mapping, Sequence
from enum import Enum
from pathlib import Path
from typing import Any, Union, get_args, get_origin, get_type_hints

from navtool.base.note import Note
from navtool.base.setting_error import Fault, SettingError, dotted


def from_plain[T](cls: type[T], value: object, *, where: str | Path, concrete: Mapping[type, type] | None = None) -> T:
    """An instance of the dataclass ``cls``, checked strictly: no unknown key, no other type, no silent conversion.

    Whole numbers are taken where a float is wanted, lists where a tuple is, and enums by the names of their members;
    nothing else is converted. Every fault of the mapping is named in one error.

    Args:
        cls: The dataclass to build; its fields may nest dataclasses, lists, tuples, dicts, enums and optional values.
        value: The parsed content.
        where: The file that the content comes from, for messages.
        concrete: For a field's dataclass, the subclass to build instead.

    Raises:
        SettingError: If a key is unknown or missing, a value has another type, or a check of the dataclass fails.
    """
    reader = _Reader(concrete or {})
    built = reader.dataclass(cls, value, "")
    if reader.faults or not isinstance(built, cls):
        raise SettingError(*reader.faults, file=where, cure="correct the named keys; see the documented fields")
    return built


def did_you_mean(word: str, known: Sequence[str]) -> str:
    """A hint such as `` (did you mean 'odometry'?)``; empty where no known word is close."""
    renamed = [_RENAMED[word]] if _RENAMED.get(word) in known else []
    close = renamed or difflib.get_close_matches(word, known, n=1)
    return f" (did you mean {close[0]!r}?)" if close else ""


_RENAMED = {"image": "camera"}
"""What keys are called now that older robot files and scripts call otherwise."""


class _Reader:
    """Builds values, and collects every fault on the way."""

    def __init__(self, concrete: Mapping[type, type]) -> None:
        self.faults: list[Fault] = []
        self._concrete = concrete

    def dataclass(self, cls: type, value: object, path: str) -> object:
        """An instance of the dataclass, or of the one that stands for it; None where there is a fault."""
        if not isinstance(value, Mapping):
            return self._refuse(path, f"wanted keys and values, got {_kind(value)}")
        cls = self._concrete.get(cls, cls)
        fields = {field.name: field for field in dataclasses.fields(cls)}
        hints = get_type_hints(cls)
        before = len(self.faults)
        arguments: dict[str, object] = {}
        for key, entry in value.items():
            place = dotted(path, str(key))
            if key not in fields:
                known = sorted(fields)
                hint = did_you_mean(str(key), known)
                self._refuse(place, f"there is no such key{hint}, known are {', '.join(known)}")
                continue
            arguments[str(key)] = self._value(hints[str(key)], entry, place)
        self.faults.extend(
            Fault(dotted(path, name), "is missing")
            for name, field in fields.items()
            if name not in value
            and field.default is dataclasses.MISSING
            and field.default_factory is dataclasses.MISSING
        )
        return None if len(self.faults) > before else self._made(cls, arguments, path)

    def _made(self, cls: type, arguments: Mapping[str, object], path: str) -> object:
        try:
            return cls(**arguments)
        except SettingError as error:
            self.faults.extend(error.below(path).faults)
            return None
        except ValueError as error:
            return self._refuse(path, str(error))

    def _refuse(self, path: str, what: str) -> object:
        self.faults.append(Fault(path, what))
        return None

    def _value(self, hint: object, value: object, path: str) -> object:
        origin, arguments = get_origin(hint), get_args(hint)
        if hint is Any:
            return value
        if origin in (Union, types.UnionType):
            return self._one_of(arguments, value, path)
        if origin is list and isinstance(value, list):
            return [self._value(arguments[0], entry, f"{path}[{i}]") for i, entry in enumerate(value)]
        if origin is tuple and isinstance(value, list):
            return self._tuple(arguments, value, path)
        if origin in (dict, Mapping) and isinstance(value, Mapping):
            return {str(key): self._value(arguments[1], entry, f"{path}.{key}") for key, entry in value.items()}
        if origin in (list, tuple, dict, Mapping):
            wanted = "a list" if origin in (list, tuple) else "keys and values"
            return self._refuse(path, f"wanted {wanted}, got {_kind(value)}")
        if hint is Note and isinstance(value, str):
            return Note.read_back(value)
        if not isinstance(hint, type):
            raise TypeError(f"{path}: fields of type {hint} are not supported")
        return self.dataclass(hint, value, path) if dataclasses.is_dataclass(hint) else self._scalar(hint, value, path)

    def _one_of(self, hints: Sequence[object], value: object, path: str) -> object:
        """A value of one of several types; where none is its own, the first one says what is wrong."""
        if value is None and types.NoneType in hints:
            return None
        inner = [hint for hint in hints if hint is not types.NoneType]
        return self._value(type(value) if type(value) in inner else inner[0], value, path)

    def _tuple(self, hints: Sequence[object], value: Sequence[object], path: str) -> object:
        each = [hints[0]] * len(value) if hints[-1] is Ellipsis else hints
        if len(each) != len(value):
            return self._refuse(path, f"wanted {len(each)} values, got {len(value)}")
        return tuple(self._value(hint, value[i], f"{path}[{i}]") for i, hint in enumerate(each))

    def _scalar(self, hint: type, value: object, path: str) -> object:
        if issubclass(hint, Enum):
            if isinstance(value, str) and value in hint.__members__:
                return hint[value]
            return self._refuse(path, f"{value!r} is none of {', '.join(hint.__members__)}")
        if hint is float and isinstance(value, int) and not isinstance(value, bool):
            return float(value)
        if isinstance(value, hint) and (hint is bool or not isinstance(value, bool)):
            return value
        return self._refuse(path, f"wanted {_NAMES.get(hint, hint.__name__)}, got {_kind(value)}")


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
