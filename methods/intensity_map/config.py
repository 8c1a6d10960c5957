"""Everything that decides the intensity maps of a run."""

import math
from dataclasses import dataclass, field
from enum import StrEnum

from navtool.base.setting_checks import fault, outside
from navtool.base.setting_error import refuse
from navtool.methods.along.config import GoalConfig
from navtool.methods.along.sweeps import SweepConfig
from navtool.pipeline.intensity_map.config import IntensityMapConfig


class SensorHeight(StrEnum):
    """Whose word on the height of the sensor counts."""

    calibration = "calibration"
    """The recording's transforms or the robot's preset; ``map.layers.sensor_height_m`` where they have none."""
    setting = "setting"
    """``map.layers.sensor_height_m``."""


@dataclass(kw_only=True, slots=True)
class OutputConfig:
    """What is written of how many maps: 1 is all, 10 every tenth, 0 none. Each cloud is mapped all the same."""

    arrays_every: int = 1
    """NumPy arrays, a file a map."""
    pictures_every: int = 10
    """PNG, a file a map."""
    mcap_every: int = 1
    """ROS 2 messages, one MCAP."""
    video_every: int = 1
    """Frames of the video."""

    def __post_init__(self) -> None:
        refuse(outside(self, 0, 100_000, *self.__slots__, cure="0 writes none"))


@dataclass(kw_only=True, slots=True)
class SensorMapConfig:
    """The maps of a sensor's sweeps: what its presets say, and what it is mounted on."""

    map: IntensityMapConfig = field(default_factory=IntensityMapConfig)
    """The grid, the layers, the thresholds, glass and inflation."""
    sweeps: SweepConfig = field(default_factory=SweepConfig)
    """What becomes of a cloud before it is mapped."""
    sensor: str = "simulated"
    """Name of the sensor's preset, for messages; by name on the command line: sensor=vlp16."""
    largest_intensity: float = 255.0
    """The largest intensity that the sensor can give, retroreflectors included: at least map.layers.full_scale."""
    sensor_height: SensorHeight = SensorHeight.calibration
    """Where the height of the sensor above the ground is from: calibration or setting."""

    def __post_init__(self) -> None:
        full_scale = self.map.layers.full_scale
        refuse(
            fault(
                "largest_intensity",
                f"{self.largest_intensity:g} is less than map.layers.full_scale = {full_scale:g}",
                "choose the sensor's preset with sensor=, or set both",
                when=not (math.isfinite(self.largest_intensity) and self.largest_intensity >= full_scale),
            )
        )


@dataclass(kw_only=True, slots=True)
class MapRunConfig(SensorMapConfig):
    """The maps, what they are made of, and what is written of them."""

    goal: GoalConfig = field(default_factory=GoalConfig)
    """Where obstacles grow away from."""
    outputs: OutputConfig = field(default_factory=OutputConfig)
    """What is written."""
