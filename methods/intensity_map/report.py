"""What a run of intensity maps reports: counts, times, notes."""

from dataclasses import dataclass, field

from navtool.base.note import Note
from navtool.methods.along.cell_scores import ClassScore
from navtool.methods.along.report import Report


@dataclass(frozen=True, slots=True, kw_only=True)
class MapReport(Report):
    """One run's maps, in figures."""

    source: str
    topic: str
    sensor: str
    clouds: int
    """In the recording."""
    maps: int
    """Made of them."""
    duration_s: float
    """From the first cloud to the last."""
    sensor_height_m: float
    height_from: str
    """``calibration`` or ``setting``."""
    skipped: dict[str, int] = field(default_factory=dict)
    """Clouds without a map, by reason."""
    points_dropped: dict[str, int] = field(default_factory=dict)
    """Points of the mapped clouds that are in no map, by reason."""
    without_odometry: int = 0
    """Maps of clouds that stand alone: no glass is remembered for them."""
    odometry_jumps: int = 0
    """How often all glass was forgotten since the odometry or its clock jumped."""
    cells: dict[str, int] = field(default_factory=dict)
    """Cells of each class over all maps."""
    maps_with: dict[str, int] = field(default_factory=dict)
    """Maps that show any cell of the class."""
    scores: dict[str, ClassScore] = field(default_factory=dict)
    """How well the classes agree with what stands there; empty where nobody knows."""
    not_scored: int = 0
    """Maps at moments when the robot's place among the outlines is not known."""
    files: dict[str, int] = field(default_factory=dict)
    """Maps in each output."""
    notes: list[Note] = field(default_factory=list)

    @property
    def maps_per_s(self) -> float | None:
        """How fast it was; None where nothing was made."""
        return self.maps / self.seconds if self.seconds > 0 else None

    def to_json(self) -> dict[str, object]:
        """As plain values."""
        return {**Report.to_json(self), "maps_per_s": self.maps_per_s}
