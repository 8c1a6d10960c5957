"""What decides the recordings of a simulation, but for its seed."""

from dataclasses import dataclass, field
from enum import StrEnum

from navtool.base.setting_checks import outside
from navtool.base.setting_error import refuse
from navtool.sim.drive.config import DriveConfig
from navtool.sim.record.bag_format import BagFormat
from navtool.sim.record.recorder_config import CameraSetup, RecorderConfig
from navtool.sim.record.rig import RobotKind
from navtool.sim.sensors.lidar_config import LidarConfig
from navtool.sim.world.scenario import ScenarioConfig


class Gait(StrEnum):
    """How the quadruped walks."""

    trot = "trot"
    crawl = "crawl"
    amble = "amble"


@dataclass(kw_only=True, slots=True)
class SimulationConfig:
    """A scenario, a robot with its sensors, how it is driven, and how that is recorded."""

    scenario: ScenarioConfig = field(default_factory=ScenarioConfig)
    """The kind of place; by name: scenario=graspe_1."""
    robot: RobotKind = RobotKind.wheeled
    """Which robot drives: wheeled or quadruped."""
    gait: Gait = Gait.trot
    """How the quadruped walks: trot, crawl or amble."""
    drive: DriveConfig = field(default_factory=DriveConfig)
    """How it is driven, and how long."""
    camera: CameraSetup = field(default_factory=CameraSetup)
    """The front camera."""
    lidar: LidarConfig = field(default_factory=LidarConfig)
    """The LiDAR."""
    recorder: RecorderConfig = field(default_factory=RecorderConfig)
    """Jitter, losses and delays."""
    truth_images: bool = False
    """Whether to record the surface and the depth of each pixel too: 60 MB a minute more."""
    format: BagFormat = BagFormat.mcap
    """How recordings are stored: mcap, db3 or ros1."""
    episodes_per_place: int = 2
    """How many episodes are driven in each place before the next one is drawn, 1 to 1000."""

    def __post_init__(self) -> None:
        refuse(outside(self, 1, 1000, "episodes_per_place"))
