"""Settings of labelling: when a rule calls a portion failed, and how far a driven path may leave a predicted one."""

import math
from dataclasses import dataclass, field

from navtool.base.errors import DatasetsError


def _require(value: float, high: float, where: str, unit: str) -> None:
    if not (math.isfinite(value) and 0.0 < value <= high):
        space = " " if unit else ""
        raise DatasetsError(
            f"{value:g}{space}{unit} is outside (0, {high:g}]{space}{unit}",
            where=where,
            cure=f"give it in {unit}" if unit else "give a share of one",
        )


@dataclass(kw_only=True, slots=True)
class CollisionConfig:
    """An acceleration spike at which the robot comes to a stop. Needs the IMU and odometry."""

    enabled: bool = True
    """Whether the rule is applied."""
    spike_mps2: float = 8.0
    """Least acceleration beside gravity and slow motion, in (0, 500]."""
    spike_sigmas: float = 8.0
    """Least spike in robust standard deviations of the recording's own vibration, in (0, 100]."""
    baseline_s: float = 1.0
    """Window of the running median that stands for gravity and slow motion, in (0, 60]."""
    speed_before_mps: float = 0.3
    """Speed that the robot had at the spike or shortly before, in (0, 50]."""
    speed_after_mps: float = 0.1
    """Speed that it falls below, in (0, speed_before_mps]."""
    stop_within_s: float = 0.5
    """Longest time between the spike and the stop, and between speed and spike, in (0, 10]."""
    after_s: float = 2.0
    """How long after the stop the rows stay failed, unless the robot drives on before, in (0, 60]."""
    confidence: float = 0.85
    """Written into ``label.confidence``, in (0, 1]."""

    def __post_init__(self) -> None:
        _require(self.spike_mps2, 500.0, "collision.spike_mps2", "m/s2")
        _require(self.spike_sigmas, 100.0, "collision.spike_sigmas", "sigmas")
        _require(self.baseline_s, 60.0, "collision.baseline_s", "s")
        _require(self.speed_before_mps, 50.0, "collision.speed_before_mps", "m/s")
        _require(self.speed_after_mps, self.speed_before_mps, "collision.speed_after_mps", "m/s")
        _require(self.stop_within_s, 10.0, "collision.stop_within_s", "s")
        _require(self.after_s, 60.0, "collision.after_s", "s")
        _require(self.confidence, 1.0, "collision.confidence", "")


@dataclass(kw_only=True, slots=True)
class StuckConfig:
    """Commanded to move, yet not moving. Needs commands and odometry."""

    enabled: bool = True
    """Whether the rule is applied."""
    command_mps: float = 0.2
    """Commanded speed from which motion is expected, in (0, 50]."""
    command_radps: float = 0.3
    """Commanded turning rate from which motion is expected, in (0, 20]."""
    moved_mps: float = 0.1
    """Measured speed below which the robot stands, in (0, command_mps]."""
    moved_radps: float = 0.15
    """Measured turning rate below which it stands, in (0, command_radps]."""
    at_least_s: float = 1.5
    """Shortest time that counts; starting to move takes less, in (0, 600]."""
    confidence: float = 0.8
    """Written into ``label.confidence``, in (0, 1]."""

    def __post_init__(self) -> None:
        _require(self.command_mps, 50.0, "stuck.command_mps", "m/s")
        _require(self.command_radps, 20.0, "stuck.command_radps", "rad/s")
        _require(self.moved_mps, self.command_mps, "stuck.moved_mps", "m/s")
        _require(self.moved_radps, self.command_radps, "stuck.moved_radps", "rad/s")
        _require(self.at_least_s, 600.0, "stuck.at_least_s", "s")
        _require(self.confidence, 1.0, "stuck.confidence", "")


@dataclass(kw_only=True, slots=True)
class FallConfig:
    """Roll or pitch beyond what the robot stands on. Needs an odometry with attitude, or the IMU."""

    enabled: bool = True
    """Whether the rule is applied."""
    tilt_rad: float = 0.8
    """Roll or pitch, of either sign, beyond which the robot has fallen, in (0, 3.2]."""
    at_least_s: float = 0.3
    """Shortest time that counts, in (0, 60]."""
    gravity_s: float = 0.5
    """Window of the running median that finds gravity in the IMU where the odometry is planar, in (0, 60]."""
    confidence: float = 0.9
    """Written into ``label.confidence``, in (0, 1]."""

    def __post_init__(self) -> None:
        _require(self.tilt_rad, 3.2, "fall.tilt_rad", "rad")
        _require(self.at_least_s, 60.0, "fall.at_least_s", "s")
        _require(self.gravity_s, 60.0, "fall.gravity_s", "s")
        _require(self.confidence, 1.0, "fall.confidence", "")


@dataclass(kw_only=True, slots=True)
class InterventionConfig:
    """The operator overrides the robot. Needs the intervention stream."""

    enabled: bool = True
    """Whether the rule is applied."""
    confidence: float = 1.0
    """Written into ``label.confidence``, in (0, 1]."""

    def __post_init__(self) -> None:
        _require(self.confidence, 1.0, "intervention.confidence", "")


@dataclass(kw_only=True, slots=True)
class LabelConfig:
    """How the label columns are made."""

    collision: CollisionConfig = field(default_factory=CollisionConfig)
    """Acceleration spike with a stop."""
    stuck: StuckConfig = field(default_factory=StuckConfig)
    """Commanded but not moving."""
    fall: FallConfig = field(default_factory=FallConfig)
    """Roll or pitch beyond a threshold."""
    intervention: InterventionConfig = field(default_factory=InterventionConfig)
    """The operator's stream."""
    success_confidence: float = 0.8
    """``label.confidence`` of rows that no rule and no event says anything about, in (0, 1]."""
    event_confidence: float = 1.0
    """``label.confidence`` of rows inside an event of the events file, in (0, 1]."""
    max_deviation_m: float = 0.25
    """Distance between the driven and the predicted position beyond which a step's label is unknown, in (0, 100].

    Half the default robot's width: up to there its swath covers the predicted path.
    """

    def __post_init__(self) -> None:
        _require(self.success_confidence, 1.0, "success_confidence", "")
        _require(self.event_confidence, 1.0, "event_confidence", "")
        _require(self.max_deviation_m, 100.0, "max_deviation_m", "m")
