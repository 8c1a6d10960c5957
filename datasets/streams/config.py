"""Settings of time: each stream's clock, method and tolerance."""

from dataclasses import dataclass, field

from navtool.base.plain import LEFT_OUT_WHILE_EMPTY
from navtool.base.setting_checks import outside
from navtool.base.setting_error import Fault, refuse
from navtool.datasets.streams.clock import Clock
from navtool.datasets.streams.clock_offsets import OffsetPolicy
from navtool.datasets.streams.sync import Method
from navtool.datasets.streams.table import GRIDDED, STREAMS, is_large, row_of, sensor_of


@dataclass(kw_only=True, slots=True)
class StreamClock:
    """Which time of a stream's messages counts."""

    clock: Clock = Clock.auto
    """auto, header or record."""
    offset_s: float | None = None
    """Added to its stamps; None leaves it to what the clocks show, 0 leaves the stamps as they are."""

    def __post_init__(self) -> None:
        refuse(self._offset_faults())

    def _offset_faults(self) -> list[Fault]:
        return outside(self, -1e10, 1e10, "offset_s", unit="s", cure="give the seconds to add to its stamps")


@dataclass(kw_only=True, slots=True)
class StreamSync(StreamClock):
    """How a stream is brought onto the grid."""

    method: Method
    """nearest, hold or linear; frames and clouds are never mixed, so for them not linear."""
    tolerance_s: float
    """nearest: how far from the tick; hold: how old; linear: how far apart the two around it. In (0, 60] seconds."""

    def __post_init__(self) -> None:
        refuse(self._offset_faults(), outside(self, 0, 60, "tolerance_s", unit="s", above=True))


@dataclass(kw_only=True, slots=True)
class FurtherSync(StreamSync):
    """How a further camera or LiDAR is brought onto the grid; what is left open is as usual for its kind."""

    method: Method = Method.nearest
    """nearest or hold."""
    tolerance_s: float = 0.06
    """nearest: how far from the tick; hold: how old. In (0, 60] seconds."""


def _default(stream: str) -> StreamSync:
    default = STREAMS[stream].sync
    if default is None:
        raise ValueError(f"{stream} is not brought onto the grid")
    return StreamSync(method=default.method, tolerance_s=default.tolerance_s)


@dataclass(kw_only=True, slots=True)
class SyncConfig:
    """The policy of time: each stream's clock, method and tolerance."""

    camera: StreamSync = field(default_factory=lambda: _default("camera"))
    """Camera frames; at the grid's own rate a frame is at most half a period away."""
    lidar: StreamSync = field(default_factory=lambda: _default("lidar"))
    """Clouds, by the stamp of their header."""
    cameras: dict[str, FurtherSync] = field(default_factory=dict, metadata=LEFT_OUT_WHILE_EMPTY)
    """Further cameras by name, where they differ from ``camera``."""
    lidars: dict[str, FurtherSync] = field(default_factory=dict, metadata=LEFT_OUT_WHILE_EMPTY)
    """Further LiDARs by name, where they differ from ``lidar``; of their clouds the rows say nothing."""
    odometry: StreamSync = field(default_factory=lambda: _default("odometry"))
    """Speeds and poses; attitudes along the shortest turn (slerp)."""
    imu: StreamSync = field(default_factory=lambda: _default("imu"))
    """Accelerations and turning rates."""
    joints: StreamSync = field(default_factory=lambda: _default("joints"))
    """Joint states."""
    battery: StreamSync = field(default_factory=lambda: _default("battery"))
    """Battery current."""
    command: StreamSync = field(default_factory=lambda: _default("command"))
    """Commanded velocities."""
    intervention: StreamClock = field(default_factory=StreamClock)
    """The operator's flag; it stays at its own rate."""
    clock_step_s: float = 0.5
    """Steps of a header clock beyond this are taken out: behind them, time goes on at the pace of record."""
    offsets: OffsetPolicy = OffsetPolicy.correct
    """What becomes of a stream whose header clock is apart from the others': correct, refuse or keep."""
    measure: bool = False
    """Whether the motion in clouds and pictures is compared with the odometry's even where no clock is suspect."""

    def __post_init__(self) -> None:
        large: dict[str, StreamSync] = {name: getattr(self, name) for name in GRIDDED if is_large(name)}
        for group, further in (("cameras", self.cameras), ("lidars", self.lidars)):
            large |= {f"{group}.{name}": entry for name, entry in further.items()}
        what, cure = "linear: images and clouds are not mixed", "use nearest or hold"
        refuse(
            outside(self, 0, 60, "clock_step_s", unit="s", above=True),
            [Fault(f"{name}.method", what, cure) for name, entry in large.items() if entry.method is Method.linear],
        )

    def of(self, stream: str) -> StreamSync | None:
        """How a stream is brought onto the grid, a further sensor as the first one unless set; None where it is not."""
        row, sensor = row_of(stream), sensor_of(stream)
        own = (self.cameras if row.name == "camera" else self.lidars).get(sensor)
        first: StreamSync | None = getattr(self, row.name) if row.sync is not None else None
        return own or first

    def clock_of(self, stream: str) -> Clock:
        """Which time of a stream counts."""
        return self._settings(stream).clock

    def offset_of(self, stream: str) -> float | None:
        """What is to be added to a stream's stamps; None where it is not set."""
        return self._settings(stream).offset_s

    def key_of(self, stream: str) -> str:
        """Where the settings of a stream stand."""
        row, sensor = row_of(stream), sensor_of(stream)
        if not sensor:
            return f"sync.{row.name}"
        return f"sync.{'cameras' if row.pose == 'base_camera' else 'lidars'}.{sensor}"

    def _settings(self, stream: str) -> StreamClock:
        settings: StreamClock = self.of(stream) or getattr(self, row_of(stream).name)
        return settings
