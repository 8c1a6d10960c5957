"""Events files: portions of recordings that a person has labelled, strictly read."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from navtool.base.errors import DatasetsError
from navtool.base.from_plain import did_you_mean
from navtool.datasets.labels.event_records import event_records
from navtool.datasets.labels.event_time import time_ns
from navtool.datasets.labels.intervals import LabelInterval

MANUAL = "event"
"""The reason of an event that gives none."""
_SHOWN = 20
_OUTCOMES = {"0": 0, "failure": 0, "1": 1, "success": 1}


@dataclass(frozen=True, slots=True)
class Bag:
    """A recording that events may speak of.

    Attributes:
        name: Its full name, such as ``outdoor/run1.bag``.
        zero_ns: What seconds are counted from, on the data set's clock.
        start_ns: Stamp of its first row.
        end_ns: Stamp of its last row.
    """

    name: str
    zero_ns: int
    start_ns: int
    end_ns: int

    def answers_to(self, name: str) -> bool:
        """Whether an event may call it so: by full name, by its last part, or by that without suffix."""
        last = self.name.rpartition("/")[2]
        return name in {self.name, last, last.rpartition(".")[0] or last}


@dataclass(frozen=True, slots=True)
class Event:
    """One event: the portion [start_ns, end_ns) of a recording, an instant where both are equal."""

    bag: str
    start_ns: int
    end_ns: int
    outcome: int
    reason: str
    line: str
    """Where it stands in the file, for messages."""

    def interval(self, confidence: float) -> LabelInterval:
        """The event as a label of rows."""
        return LabelInterval(self.start_ns, self.end_ns, self.outcome, self.reason, confidence)


def read_events(path: Path, bags: Sequence[Bag]) -> tuple[Event, ...]:
    """The events of a CSV or JSON file, in its order; a later one wins over an earlier one of equal outcome.

    A CSV file starts with the header ``bag,start,end,outcome,reason`` (in any order); a JSON file is a list of
    objects with these keys. ``bag`` is the name of a recording, ``outcome`` 0, 1, failure or success; ``reason`` may be
    empty. Times are
    seconds since the recording's start, or absolute: seconds or nanoseconds since 1970, or ISO 8601 with a time zone.

    Args:
        path: A file that ends in ``.csv`` or ``.json``.
        bags: The recordings of the data set.

    Raises:
        DatasetsError: If the file cannot be read, or any of its lines is faulty, names no known recording, lies
            outside its recording, or contradicts another line; all such lines are named.
    """
    faults: list[str] = []
    events: list[Event] = []
    for line, fields in event_records(path, faults):
        event = _event(line, fields, bags, faults)
        if event is not None:
            events.append(event)
    faults.extend(_contradictions(events))
    if faults:
        more = [f"and {len(faults) - _SHOWN} more"] if len(faults) > _SHOWN else []
        raise DatasetsError(
            "\n  ".join([f"{len(faults)} faults", *faults[:_SHOWN], *more]), where=path, cure="correct these lines"
        )
    return tuple(events)


def _event(line: str, fields: Mapping[str, object], bags: Sequence[Bag], faults: list[str]) -> Event | None:
    before = len(faults)
    bag = _bag(line, fields["bag"], bags, faults)
    zero_ns = bag.zero_ns if bag is not None else 0
    start_ns, end_ns = (_time(line, name, fields[name], zero_ns, faults) for name in ("start", "end"))
    outcome = _OUTCOMES.get(str(fields["outcome"]))
    if outcome is None or isinstance(fields["outcome"], bool):
        faults.append(f"{line}: outcome {fields['outcome']!r} is neither success (1) nor failure (0)")
    reason = fields["reason"]
    if not isinstance(reason, str) or not reason.isprintable():
        faults.append(f"{line}: reason {reason!r} is not a line of text")
    if len(faults) == before and end_ns < start_ns:
        faults.append(f"{line}: ends {(start_ns - end_ns) * 1e-9:g} s before it starts")
    elif len(faults) == before and bag is not None and (end_ns < bag.start_ns or start_ns > bag.end_ns):
        first, last = ((stamp - zero_ns) * 1e-9 for stamp in (bag.start_ns, bag.end_ns))
        faults.append(f"{line}: lies outside of {bag.name}, which lasts from {first:.3f} s to {last:.3f} s")
    if len(faults) > before or bag is None or outcome is None:
        return None
    return Event(bag.name, start_ns, end_ns, outcome, str(reason) or MANUAL, line)


def _bag(line: str, name: object, bags: Sequence[Bag], faults: list[str]) -> Bag | None:
    known = sorted(bag.name for bag in bags)
    exact = [bag for bag in bags if bag.name == name]
    found = exact or [bag for bag in bags if isinstance(name, str) and bag.answers_to(name)]
    if len(found) == 1:
        return found[0]
    if found:
        faults.append(f"{line}: bag {name!r} is one of {', '.join(sorted(bag.name for bag in found))}; name which")
    else:
        listed = ", ".join(known[:_SHOWN]) + (f" and {len(known) - _SHOWN} more" if len(known) > _SHOWN else "")
        faults.append(f"{line}: unknown bag {name!r}{did_you_mean(str(name), known)}, known are {listed or 'none'}")
    return None


def _time(line: str, name: str, value: object, zero_ns: int, faults: list[str]) -> int:
    try:
        return time_ns(value, zero_ns)
    except ValueError as error:
        faults.append(f"{line}: {name} {error}")
        return 0


def _contradictions(events: Sequence[Event]) -> list[str]:
    """Pairs of lines that give one portion of a recording both outcomes."""
    found = []
    by_bag: dict[str, list[Event]] = {}
    for event in events:
        by_bag.setdefault(event.bag, []).append(event)
    for of_bag in by_bag.values():
        ordered = sorted(of_bag, key=lambda event: (event.start_ns, event.end_ns))
        for index, event in enumerate(ordered):
            for later in ordered[index + 1 :]:
                if later.start_ns >= max(event.end_ns, event.start_ns + 1):
                    break
                if later.outcome != event.outcome:
                    found.append(f"{event.line} and {later.line} overlap in {event.bag} with outcomes 0 and 1")
    return found
