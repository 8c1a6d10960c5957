"""Settings of labelling: when a rule calls a portion failed, and how far a driven path may leave a predicted one."""

from dataclasses import dataclass, field

from navtool.base.setting_checks import outside
from navtool.base.setting_error import refuse

_SHARE = "give a share of one"


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
        refuse(
            outside(self, 0, 500, "spike_mps2", unit="m/s2", above=True),
            outside(self, 0, 100, "spike_sigmas", unit="sigmas", above=True),
            outside(self, 0, 60, "baseline_s", "after_s", unit="s", above=True),
            outside(self, 0, 50, "speed_before_mps", unit="m/s", above=True),
            outside(self, 0, self.speed_before_mps, "speed_after_mps", unit="m/s", above=True),
            outside(self, 0, 10, "stop_within_s", unit="s", above=True),
            outside(self, 0, 1, "confidence", above=True, cure=_SHARE),
        )


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
        refuse(
            outside(self, 0, 50, "command_mps", unit="m/s", above=True),
            outside(self, 0, 20, "command_radps", unit="rad/s", above=True),
            outside(self, 0, self.command_mps, "moved_mps", unit="m/s", above=True),
            outside(self, 0, self.command_radps, "moved_radps", unit="rad/s", above=True),
            outside(self, 0, 600, "at_least_s", unit="s", above=True),
            outside(self, 0, 1, "confidence", above=True, cure=_SHARE),
        )


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
        refuse(
            outside(self, 0, 3.2, "tilt_rad", unit="rad", above=True),
            outside(self, 0, 60, "at_least_s", "gravity_s", unit="s", above=True),
            outside(self, 0, 1, "confidence", above=True, cure=_SHARE),
        )


@dataclass(kw_only=True, slots=True)
class InterventionConfig:
    """The operator overrides the robot. Needs the intervention stream."""

    enabled: bool = True
    """Whether the rule is applied."""
    confidence: float = 1.0
    """Written into ``label.confidence``, in (0, 1]."""

    def __post_init__(self) -> None:
        refuse(outside(self, 0, 1, "confidence", above=True, cure=_SHARE))


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
        refuse(
            outside(self, 0, 1, "success_confidence", "event_confidence", above=True, cure=_SHARE),
            outside(self, 0, 100, "max_deviation_m", unit="m", above=True),
        )
