"""A small place, drives through it, and their recordings."""

from collections.abc import Callable
from pathlib import Path

import pytest
from arc_drive import arc_drive

from navtool.sim.drive.config import DriveConfig
from navtool.sim.drive.failure import Failure, FailureKind
from navtool.sim.record.bag_format import BagFormat
from navtool.sim.record.bag_writer import write_bag
from navtool.sim.record.config import SimulationConfig
from navtool.sim.record.messages import MessageFactory
from navtool.sim.record.recorder_config import CameraSetup
from navtool.sim.record.rig import RIGS, RobotKind
from navtool.sim.record.stage import Stage, make_stage
from navtool.sim.record.streams import Take, entries
from navtool.sim.sensors.lidar_config import LidarConfig
from navtool.sim.world.scenario import RegionConfig, Scatter, ScenarioConfig

FAILURES = (
    Failure(FailureKind.stuck, 0.3, 0.9, 1.0, 0.1, "no headway"),
    Failure(FailureKind.collision, 1.2, 1.6, 1.4, 0.2, "against a wall"),
)
SMALL = CameraSetup(width=64, height=48)
SECONDS = 1.5
Record = Callable[..., Path]


@pytest.fixture(scope="session")
def place() -> ScenarioConfig:
    """Level ground of two surfaces with a few things on it."""
    return ScenarioConfig(
        name="yard",
        side_m=20.0,
        cell_m=0.25,
        course_m=10.0,
        hills_m=0.0,
        ground="concrete",
        regions=[RegionConfig(surface="asphalt", share=0.4, size_m=3.0)],
        trees=Scatter(count=2),
        walls=Scatter(count=2),
        glass_panels=Scatter(count=1),
        grass_patches=Scatter(count=1),
    )


@pytest.fixture(scope="session")
def stage(place: ScenarioConfig) -> Stage:
    return make_stage(place, 0)


@pytest.fixture(scope="session")
def take_of(stage: Stage) -> Callable[..., Take]:
    """A factory of takes of a short drive."""

    def make(**settings: object) -> Take:
        rig = RIGS[RobotKind.wheeled]
        given = {"drive": arc_drive(2.0, failures=FAILURES), "camera": SMALL, "rig": rig, **settings}
        return Take(stage=stage, **given)  # type: ignore[arg-type]

    return make


@pytest.fixture(scope="session")
def record(take_of: Callable[..., Take]) -> Record:
    """A factory of recordings of that drive in a folder."""

    def make(folder: Path, kind: BagFormat = BagFormat.mcap, **settings: object) -> Path:
        take = take_of(**settings)
        factory = MessageFactory(ros1=kind is BagFormat.ros1)
        path = folder / f"run{kind.suffix}"
        write_bag(path, kind, factory.store, take.topics(), entries(take, factory), folder / ".partial")
        return path

    return make


@pytest.fixture(scope="session")
def tiny(place: ScenarioConfig) -> Callable[..., SimulationConfig]:
    """A factory of configurations with a small camera, one laser and short drives."""

    def make(**settings: object) -> SimulationConfig:
        one_laser = LidarConfig(elevation_rad=[-0.1], firing_order=[0])
        drive = DriveConfig(duration_s=SECONDS)
        given = {"scenario": place, "camera": SMALL, "lidar": one_laser, "drive": drive}
        given |= {"episodes_per_place": 3, **settings}
        return SimulationConfig(**given)  # type: ignore[arg-type]

    return make
