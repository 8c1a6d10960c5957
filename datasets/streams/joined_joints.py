"""Joints of one topic that come in several messages: joined by name, whoever publishes which of them in what order."""

import numpy as np
from jaxtyping import Bool, Float64

from navtool.base.note import Note
from navtool.datasets.streams.recorded_stream import RecordedStream
from navtool.datasets.streams.rows import JOINT_KINDS, joint_columns
from navtool.pipeline.arrays import Array

_STILL = 1e-9
_NAMES_SAID = 4


def join_joints(stream: RecordedStream, wanted: tuple[str, ...]) -> list[Note]:
    """Bring the rows of a joint stream, each in its message's own order, into one table with a column a value.

    A joint that several publishers name is taken from those of them whose values move, where others repeat one value,
    as those do that fill in joints that they do not measure. Messages of one stamp become one row. Messages without any
    wanted joint are left out.

    Args:
        wanted: The joints in their order; empty takes all, in the order in which they come up.

    Returns:
        What a user should know.
    """
    sets = [source.joints for source in stream.sources]
    names = wanted or tuple(dict.fromkeys(name for joints in sets for name in joints))
    numbers: Array = np.array(stream.source)
    values, present = _table(stream, sets, names, numbers)
    stream.rows, stream.joint_names, stream.columns = [], names, joint_columns(names)
    notes = _without_fillers(values, present, sets, names, numbers)
    stream.present, stream.table = None if present.all() else present, values.reshape(len(values), -1)
    naming: Array = np.asarray(present.any(axis=1))
    if naming.any() and not naming.all():
        stream.left_out += int(np.count_nonzero(~naming))
        stream.take(naming)
    several = [joints for joints in dict.fromkeys(frozenset(joints) & set(names) for joints in sets) if joints]
    if len(several) > 1:
        _join_equal_stamps(stream)
        said = " and ".join(_some([name for name in names if name in joints]) for joints in several)
        notes.append(Note("joints.joined", f"joints: messages that name different joints are joined by name: {said}"))
    return notes


def _table(
    stream: RecordedStream, sets: list[tuple[str, ...]], names: tuple[str, ...], numbers: Array
) -> tuple[Float64[Array, "n 3 joints"], Bool[Array, "n joints"]]:
    """Values of each message, NaN for joints that it does not name, and which it names."""
    values = np.full((len(stream.rows), len(JOINT_KINDS), len(names)), np.nan)
    present = np.zeros((len(stream.rows), len(names)), dtype=np.bool_)
    for number, joints in enumerate(sets):
        messages = np.flatnonzero(numbers == number)
        place = {name: index for index, name in enumerate(joints)}
        columns = np.array([column for column, name in enumerate(names) if name in place], dtype=np.int64)
        if not columns.size:
            continue
        rows = np.array([stream.rows[message] for message in messages.tolist()], dtype=np.float64)
        rows = rows.reshape(len(messages), len(JOINT_KINDS), len(joints))
        from_columns = [place[names[column]] for column in columns.tolist()]
        values[np.ix_(messages, np.arange(len(JOINT_KINDS)), columns)] = rows[:, :, from_columns]
        present[np.ix_(messages, columns)] = True
    return values, present


def _without_fillers(
    values: Float64[Array, "n 3 joints"],
    present: Bool[Array, "n joints"],
    sets: list[tuple[str, ...]],
    names: tuple[str, ...],
    numbers: Array,
) -> list[Note]:
    """Take out, in place, the values of publishers that repeat one value of a joint that moves for another."""
    taken_out = []
    for column, name in enumerate(names):
        of = [number for number, joints in enumerate(sets) if name in joints]
        if len({frozenset(sets[number]) for number in of}) < 2:
            continue
        moving = [number for number in of if _moves(values[numbers == number, :, column])]
        if moving and len(moving) < len(of):
            still = np.isin(numbers, [number for number in of if number not in moving])
            values[still, :, column], present[still, column] = np.nan, False
            taken_out.append(name)
    if not taken_out:
        return []
    what = f"joints: {_some(taken_out)} are published twice; the values that never change are left out"
    return [Note("joints.published-twice", what)]


def _moves(values: Float64[Array, "n 3"]) -> bool:
    known = np.where(np.isfinite(values), values, 0.0)
    return bool(len(known)) and bool((np.ptp(known, axis=0) > _STILL).any())


def _join_equal_stamps(stream: RecordedStream) -> None:
    """Make one row of messages of one stamp that name different joints, so that none counts as a repetition."""
    if stream.table is None or stream.present is None:
        return
    header_ns, _ = stream.stamps
    times = np.where(header_ns > 0, header_ns, -1 - np.arange(header_ns.size))
    _, first, group = np.unique(times, return_index=True, return_inverse=True)
    adding: Array = np.zeros(header_ns.size, dtype=np.bool_)
    joints = stream.present.shape[1]
    for column in range(joints):
        naming = np.flatnonzero(stream.present[:, column])
        rows = naming[np.unique(group[naming], return_index=True)[1]]
        onto = first[group[rows]]
        columns = column + joints * np.arange(len(JOINT_KINDS))
        stream.table[np.ix_(onto, columns)] = stream.table[np.ix_(rows, columns)]
        stream.present[onto, column] = True
        adding[rows] = True
    adding[first] = False
    stream.take(~adding)


def _some(names: tuple[str, ...] | list[str]) -> str:
    said = ", ".join(names[:_NAMES_SAID])
    return f"{said} and {len(names) - _NAMES_SAID} more" if len(names) > _NAMES_SAID else said
