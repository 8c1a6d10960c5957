"""The clocks of a recording's streams, brought onto one."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Int64

from navtool.base.errors import DatasetsError
from navtool.datasets.streams.clock import Jump, StreamTime, mend_jumps, reference_clock, stream_time
from navtool.datasets.streams.config import SyncConfig
from navtool.datasets.streams.first_pass import FirstPass
from navtool.pipeline.arrays import Array


@dataclass(frozen=True, slots=True)
class Clocks:
    """Header stamps and record times of every stream, the steps of header clocks taken out.

    Attributes:
        header_ns: Stamps per stream in the order of record; -1 without header, 0 where it was left empty.
        record_ns: When each message was recorded.
        jumps: The steps that were taken out.
    """

    header_ns: dict[str, Int64[Array, " n"]]
    record_ns: dict[str, Int64[Array, " n"]]
    jumps: dict[str, tuple[Jump, ...]]
    policy: SyncConfig

    @classmethod
    def of(cls, found: FirstPass, policy: SyncConfig) -> "Clocks":
        """The clocks of what the first pass found."""
        header_ns, record_ns, jumps = {}, {}, {}
        for name, stream in found.streams.items():
            recorded, record_ns[name] = stream.stamps
            header_ns[name], jumps[name] = mend_jumps(recorded, record_ns[name], round(policy.clock_step_s * 1e9))
        return cls(header_ns, record_ns, jumps, policy)

    def times(self, grid_stream: str) -> dict[str, StreamTime]:
        """Every stream's time on the clock of the one that makes the grid.

        Raises:
            DatasetsError: The settings ask for header stamps where there are none.
        """
        reference = reference_clock(self.header_ns[grid_stream], self.record_ns[grid_stream])
        times = {}
        for name, header_ns in self.header_ns.items():
            try:
                times[name] = stream_time(header_ns, self.record_ns[name], reference, self.policy.clock_of(name))
            except DatasetsError as error:
                raise DatasetsError(error.what, where=name, cure=error.cure) from error
        return times

    def on_clock_of(self, grid_stream: str, record_ns: int) -> int:
        """A time of record on a stream's clock, which is another one where recording was done in simulated time."""
        reference = reference_clock(self.header_ns[grid_stream], self.record_ns[grid_stream])
        moment = np.array([record_ns], dtype=np.int64)
        return int(moment[0] if reference is None else reference.from_record(moment)[0])
