"""Definitions that lack a standard type, completed by the one that ROS has always had."""

from collections.abc import Callable
from typing import Any, NamedTuple

from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_typestore
from rosbags.typesys.store import Typestore

from navtool.base.errors import DatasetsError
from navtool.datasets.recording.source import Definition

_HEADER = "std_msgs/msg/Header"
_OLD_HEADER = "roslib/msg/Header"
"""As bags from before 2011 call it."""
_BUILT_IN = frozenset(get_typestore(Stores.EMPTY).fielddefs)
"""Types that no definition has to define."""


class Completed(NamedTuple):
    """Types by name as rosbags has them, and what they were completed with."""

    types: dict[str, Any]
    told: str


def completed(
    parse: Callable[[Definition, str], dict[str, Any]],
    definition: Definition,
    name: str,
    md5sum: str,
    standard: Typestore,
) -> Completed:
    """The types of a definition with the standard ones that it names and lacks.

    A type that has a checksum counts only as what the checksum says. Without one, a standard type counts only where the
    fields that the recording does define are the standard's.

    Args:
        parse: Reads the definition of a type; raises whatever it likes where it cannot.
        md5sum: Of the type as recorded; empty where it is not known.
        standard: The types of the recording's ROS distribution.

    Raises:
        DatasetsError: It cannot be completed so.
    """
    try:
        types = dict(parse(definition, name))
    except Exception:
        whole = _closure(name, standard.fielddefs)
        if whole is None or not md5sum or _md5sum(whole, name) != md5sum:
            raise
        return Completed(
            whole, "its definition cannot be read; its checksum is that of the standard type, by which it is read"
        )
    lacking = _lacking(name, types)
    if not lacking:
        return Completed(types, "")
    if _OLD_HEADER in types and _HEADER in lacking:
        types[_HEADER] = types[_OLD_HEADER]
    for missing in sorted(_lacking(name, types)):
        source = _HEADER if missing == _OLD_HEADER else missing
        found = _closure(source, standard.fielddefs)
        if found is None:
            raise DatasetsError(f"its definition cannot be read: it lacks that of {missing}")
        types = {missing: found[source]} | found | types
    if not _believed(name, types, md5sum, standard):
        raise DatasetsError(f"its definition cannot be read: it lacks that of {', '.join(sorted(lacking))}")
    if lacking == {_HEADER} and _OLD_HEADER in types:
        return Completed(types, "")
    return Completed(types, f"its definition lacks that of {', '.join(sorted(lacking))}; the standard one is taken")


def _believed(name: str, types: dict[str, Any], md5sum: str, standard: Typestore) -> bool:
    if md5sum and md5sum != "*":
        return _md5sum(types, name) == md5sum
    return name not in standard.fielddefs or standard.fielddefs[name][1] == types[name][1]


def _lacking(name: str, types: dict[str, Any]) -> set[str]:
    """Types that are named and not defined, among those that the type has within."""
    lacking, seen, open_ones = set(), {name}, [name]
    while open_ones:
        for within in _named(types[open_ones.pop()]):
            if within in seen or within in _BUILT_IN:
                continue
            seen.add(within)
            if within in types:
                open_ones.append(within)
            else:
                lacking.add(within)
    return lacking


def _named(fields: Any) -> list[str]:
    return [kind for kind in map(_name_in, (kind for _, kind in fields[1])) if kind]


def _name_in(kind: Any) -> str:
    if kind[0] == Nodetype.NAME:
        return str(kind[1])
    return "" if kind[0] == Nodetype.BASE else _name_in(kind[1][0])


def _closure(name: str, known: Any) -> dict[str, Any] | None:
    """A type with all that it has within; None where it is not known."""
    if name not in known:
        return None
    found, open_ones = {name: known[name]}, [name]
    while open_ones:
        for within in _named(found[open_ones.pop()]):
            if within not in found and within not in _BUILT_IN:
                found[within] = known[within]
                open_ones.append(within)
    return found


def _md5sum(types: dict[str, Any], name: str) -> str:
    store = get_typestore(Stores.EMPTY)
    store.register(types)
    return store.generate_msgdef(name, ros_version=1)[1]
