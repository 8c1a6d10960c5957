"""The clocks of a recording's streams, brought onto one."""

from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Bool, Int64

from navtool.base.errors import DatasetsError
from navtool.base.note import Note
from navtool.datasets.streams.clock import (
    OTHER_EPOCH_NS,
    Clock,
    Jump,
    ReferenceClock,
    StreamTime,
    mend_jumps,
    reference_clock,
    stream_time,
)
from navtool.datasets.streams.clock_offsets import (
    AHEAD_S,
    OFFSET,
    ClockOffset,
    OffsetPolicy,
    Shift,
    compare_clocks,
    latency_of,
)
from navtool.datasets.streams.config import SyncConfig
from navtool.datasets.streams.first_pass import FirstPass
from navtool.pipeline.arrays import Array


@dataclass(frozen=True, slots=True)
class Clocks:
    """Header stamps and record times of every stream, the steps of header clocks taken out.

    Attributes:
        header_ns: Stamps per stream in the order of record, on one clock as far as that is known; -1 without header, 0
            where it was left empty.
        recorded_ns: The same as recorded, but for steps.
        record_ns: When each message was recorded.
        jumps: The steps that were taken out.
        kept: Which messages are read of streams that share a topic with another sensor.
        offsets: Streams whose header clock is apart from the others', or may be.
        level_s: How far the clock that most streams share is ahead of the recorder's.
        skipped: Messages at the beginning of videos that no picture comes of.
    """

    header_ns: dict[str, Int64[Array, " _"]]
    recorded_ns: dict[str, Int64[Array, " _"]]
    record_ns: dict[str, Int64[Array, " _"]]
    jumps: dict[str, tuple[Jump, ...]]
    policy: SyncConfig
    kept: dict[str, Bool[Array, " _"]] = field(default_factory=dict)
    offsets: dict[str, ClockOffset] = field(default_factory=dict)
    level_s: float = 0.0
    skipped: dict[str, int] = field(default_factory=dict)

    @classmethod
    def of(cls, found: FirstPass, policy: SyncConfig) -> "Clocks":
        """The clocks of what the first pass found, those that are apart treated as the policy says.

        Raises:
            DatasetsError: A clock is apart, and the policy refuses that.
        """
        header_ns, record_ns, jumps = {}, {}, {}
        kept = {name: stream.kept for name, stream in found.streams.items() if stream.kept is not None}
        for name, stream in found.streams.items():
            header_ns[name], record_ns[name] = stream.stamps
            read = np.flatnonzero(kept.get(name, np.ones(record_ns[name].size, dtype=np.bool_)))
            step_ns = round(policy.clock_step_s * 1e9)
            header_ns[name][read], steps = mend_jumps(header_ns[name][read], record_ns[name][read], step_ns)
            jumps[name] = tuple(Jump(int(read[step.position]), step.by_ns) for step in steps)
        clocks = cls(dict(header_ns), header_ns, record_ns, jumps, policy, kept)
        latencies = {
            name: latency
            for name in header_ns
            if policy.clock_of(name) is not Clock.record
            and (latency := latency_of(name, *clocks._read(name))) is not None
        }
        given = {name: seconds for name in header_ns if (seconds := policy.offset_of(name)) is not None}
        compared = compare_clocks(latencies, given)
        videos = {name: video for name, stream in found.streams.items() if (video := stream.video) is not None}
        skipped = {name: video.before_first_key for name, video in videos.items()}
        clocks = replace(clocks, level_s=compared.level_s, skipped=skipped)
        for name, seconds in given.items():
            clocks = clocks.shifted(name, ClockOffset(-seconds, Shift(seconds, exact=True) if seconds else None))
        for name, offset in compared.offsets.items():
            clocks = clocks.shifted(name, offset)
        return clocks

    def shifted(self, stream: str, offset: ClockOffset) -> "Clocks":
        """The clocks with a stream's offset, its stamps shifted where it says so and the policy allows it.

        Raises:
            DatasetsError: The clock is apart, and the policy refuses that.
        """
        set_by_hand = self.policy.offset_of(stream) is not None
        if offset.shift is not None and not set_by_hand:
            offset = self._as_declared(stream, offset)
        stamps = self.recorded_ns[stream]
        if offset.shift is not None:
            stamps = np.where(stamps > 0, stamps + offset.shift.of(self.record_ns[stream]), stamps)
        return replace(self, header_ns=self.header_ns | {stream: stamps}, offsets=self.offsets | {stream: offset})

    def times(self, grid_stream: str) -> dict[str, StreamTime]:
        """Every stream's time on the clock of the one that makes the grid.

        Raises:
            DatasetsError: The settings ask for header stamps where there are none.
        """
        reference = self._reference(grid_stream)
        times = {}
        for name, header_ns in self.header_ns.items():
            try:
                clock = self.policy.clock_of(name)
                time = stream_time(header_ns, self.record_ns[name], reference, clock, self.kept.get(name))
            except DatasetsError as error:
                raise DatasetsError(error.what, where=name, cure=error.cure) from error
            seconds = self.policy.offset_of(name)
            if seconds and time.source == "record":
                time = replace(time, stamps_ns=time.stamps_ns + round(seconds * 1e9))
            times[name] = time.from_position(self.skipped.get(name, 0))
        return times

    def on_clock_of(self, grid_stream: str, record_ns: int) -> int:
        """A time of record on a stream's clock, which is another one where recording was done in simulated time."""
        reference = self._reference(grid_stream)
        moment = np.array([record_ns], dtype=np.int64)
        return int(moment[0] if reference is None else reference.from_record(moment)[0])

    def as_recorded(self, stream: str) -> tuple[Int64[Array, " m"], Int64[Array, " m"]]:
        """Stamps, but for steps, and times of record of the messages that are read."""
        kept = self.kept.get(stream, slice(None))
        return self.recorded_ns[stream][kept], self.record_ns[stream][kept]

    def notes(self, stream: str) -> list[Note]:
        """What a user should know of a stream's clock against the others'."""
        offset = self.offsets.get(stream)
        return [] if offset is None or offset.note is None else [offset.note]

    def _reference(self, grid_stream: str) -> ReferenceClock | None:
        """The grid's clock; where all headers are apart from the recorder's, it is another one by however little."""
        apart_ns = OTHER_EPOCH_NS if self.level_s == 0.0 else round(AHEAD_S * 1e9)
        return reference_clock(*self._read(grid_stream), apart_ns)

    def _read(self, stream: str) -> tuple[Int64[Array, " m"], Int64[Array, " m"]]:
        """Stamps and times of record of the messages that are read."""
        kept = self.kept.get(stream, slice(None))
        return self.header_ns[stream][kept], self.record_ns[stream][kept]

    def _as_declared(self, stream: str, offset: ClockOffset) -> ClockOffset:
        said = offset.note.text if offset.note is not None else "its header clock is apart from the others'"
        seconds = 0.0 if offset.shift is None else offset.shift.seconds
        key = f"{self.policy.key_of(stream)}.offset_s"
        if self.policy.offsets is OffsetPolicy.refuse:
            what = said.partition(";")[0]
            cure = f"set {key}={seconds:.3f}, or sync.offsets=correct to have it shifted"
            raise DatasetsError(what, where=stream, cure=cure)
        if self.policy.offsets is OffsetPolicy.keep:
            text = f"{said.partition(';')[0]}; its stamps stay, as set; {key}={seconds:.3f} would shift them"
            return ClockOffset(offset.apart_s, None, Note(OFFSET, text))
        return ClockOffset(offset.apart_s, offset.shift, Note(OFFSET, f"{said}; {key}= sets it by hand"))
