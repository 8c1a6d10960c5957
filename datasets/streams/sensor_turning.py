"""How a camera or a LiDAR turned, by what it saw."""

from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from jaxtyping import Int64

from navtool.base.errors import DatasetsError
from navtool.datasets.decode.messages import ImageFrame, PointCloud
from navtool.datasets.recording import Recording
from navtool.datasets.streams.clock import StreamTime
from navtool.pipeline.arrays import Array
from navtool.pipeline.time_offset import Turning
from navtool.pipeline.turning import range_profile, shift_between, small_grey, turn_between

_LEAST_STEP_NS = 80_000_000
"""What comes faster is looked at so far apart."""
_SWEEP_S = 0.5
"""Point times beyond this are none."""


def sensor_turning(
    recording: Recording,
    topic: str,
    record_ns: Int64[Array, " n"],
    time: StreamTime,
    span_ns: tuple[int, int],
    origin_ns: int,
) -> Turning | None:
    """The turning that the clouds or pictures of a stretch of time show; None where too few are usable.

    Pictures turn by shares of their width, whose scale is that of the lens.

    Args:
        topic: The sensor's.
        record_ns: When all of its messages were recorded.
        time: The stream's.
        span_ns: From, to, by the stream's stamps.
        origin_ns: From which the seconds are counted.
    """
    wanted = _spread(time, span_ns)
    if len(wanted) < 3:
        return None
    views = sorted(_views(recording, topic, record_ns, wanted), key=lambda view: view.stamp_ns)
    turns = [
        (turn_between if now.cloud else shift_between)(before.seen, now.seen)
        for before, now in pairwise(views)
        if before.cloud == now.cloud
    ]
    times_s = np.array([(view.stamp_ns - origin_ns) * 1e-9 + view.later_s for view in views])
    if len(turns) < 2 or len(turns) != times_s.size - 1 or (np.diff(times_s) <= 0).any():
        return None
    return Turning(times_s, np.concatenate([[0.0], np.cumsum(turns)]))


class _View(NamedTuple):
    """What is compared of a cloud or a picture."""

    stamp_ns: int
    later_s: float
    """How much later than the stamp it was seen."""
    cloud: bool
    seen: Array


def _spread(time: StreamTime, span_ns: tuple[int, int]) -> dict[int, int]:
    """Stamps by position in the order of record, of messages that lie apart within the stretch."""
    wanted: dict[int, int] = {}
    last_ns: int | None = None
    first, end = np.searchsorted(time.stamps_ns, span_ns)
    for index in range(int(first), int(end)):
        stamp_ns = int(time.stamps_ns[index])
        if last_ns is None or stamp_ns - last_ns >= _LEAST_STEP_NS:
            wanted[int(time.order[index])] = stamp_ns
            last_ns = stamp_ns
    return wanted


def _views(recording: Recording, topic: str, record_ns: Int64[Array, " n"], wanted: dict[int, int]) -> Iterator[_View]:
    """The wanted messages as far as they can be decoded; memory holds what is compared alone."""
    start_ns, end_ns = int(record_ns[min(wanted)]), int(record_ns[max(wanted)])
    first = int(np.searchsorted(record_ns, start_ns))
    for position, raw in enumerate(recording.messages((topic,), start_ns, end_ns), first):
        if position not in wanted:
            continue
        try:
            sample = recording.decode(raw)
        except DatasetsError:
            continue
        if isinstance(sample, ImageFrame):
            yield _View(wanted[position], 0.0, cloud=False, seen=small_grey(sample.rgb))
        elif isinstance(sample, PointCloud) and (profile := range_profile(sample.xyz)) is not None:
            yield _View(wanted[position], _middle_s(sample), cloud=True, seen=profile)


def _middle_s(cloud: PointCloud) -> float:
    """The middle of a sweep, seconds from its stamp; 0 where its points have no times."""
    if cloud.time_s is None or not cloud.time_s.size:
        return 0.0
    middle = float(np.median(cloud.time_s))
    return middle if abs(middle) < _SWEEP_S else 0.0
