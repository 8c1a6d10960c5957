"""Whole drives in the scenarios' places: enough trouble and not too much, determinism, and courses that arrive."""

from collections.abc import Callable

import numpy as np
import pytest
from omegaconf import OmegaConf

from navtool.base.setting_error import SettingError
from navtool.configs.schema import config_folder
from navtool.pipeline.arrays import Array
from navtool.pipeline.geometry.transforms import rpy_from_transform
from navtool.sim.drive.config import DriveConfig, DriverKind, PoseConfig
from navtool.sim.drive.drive import Drive
from navtool.sim.drive.failure import FailureKind
from navtool.sim.drive.make import roll_out
from navtool.sim.drive.script import Order, Waypoint
from navtool.sim.errors import SimError
from navtool.sim.wheeled.config import BASE_HEIGHT_M
from navtool.sim.wheeled.robot import WheeledRobot
from navtool.sim.world.obstacle import Obstacles
from navtool.sim.world.place import World

Places = Callable[[str, int], World]
SCENARIOS = sorted(path.stem for path in (config_folder() / "scenario").glob("*.yaml"))


def outside(drive: Drive, obstacles: Obstacles) -> float:
    """Least distance of points on the footprint's rim from what is solid."""
    rim: Array = np.array([(x, y) for x in np.linspace(-0.495, 0.495, 12) for y in (-0.335, 0.335)])
    rim = np.concatenate([rim, [(x, y) for x in (-0.495, 0.495) for y in np.linspace(-0.335, 0.335, 8)]])
    pose = drive.pose(drive.time_s[::10])
    middle = pose[:, :2, 3] - BASE_HEIGHT_M * pose[:, :2, 2]  # on the ground: base_link leans with the robot
    yaw = rpy_from_transform(pose)[:, 2]
    level = np.stack([np.stack([np.cos(yaw), -np.sin(yaw)], -1), np.stack([np.sin(yaw), np.cos(yaw)], -1)], 1)
    points = np.einsum("nij,kj->nki", level, rim) + middle[:, None]
    return float(obstacles.only(pliable=False).clearance(points[..., 0], points[..., 1]).min())


def survey(places: Places, name: str, seeds: range, duration_s: float) -> list[Drive]:
    drives = []
    for seed in seeds:
        world = places(name, seed // 4)
        drives.append(roll_out(WheeledRobot(world), world, DriveConfig(duration_s=duration_s), seed))
        assert outside(drives[-1], world.obstacles) >= 0.0, seed
        room = world.config.room
        if room is not None:
            x, y = np.abs(drives[-1].position_m[:, :2]).max(axis=0)
            assert x < room.length_m / 2, seed
            assert y < room.width_m / 2, seed
    return drives


def test_random_drives_fail_and_succeed(scenario_world: Places) -> None:
    drives = [
        drive for name in ("graspe_3", "amco_4", "mim_2") for drive in survey(scenario_world, name, range(4), 20.0)
    ]
    assert 0 < sum(bool(drive.failures) for drive in drives) < len(drives)
    assert np.mean([drive.failed_share for drive in drives]) < 0.5


@pytest.mark.slow
@pytest.mark.parametrize("name", SCENARIOS)
def test_in_every_scenario_some_drives_fail_and_some_do_not(name: str, scenario_world: Places) -> None:
    drives = survey(scenario_world, name, range(12), 60.0)
    failing = sum(bool(drive.failures) for drive in drives)
    assert 0 < failing < len(drives)
    assert np.mean([drive.failed_share for drive in drives]) < 0.5
    driven = [np.hypot(*np.diff(drive.position_m[:, :2], axis=0).T).sum() for drive in drives]
    assert min(driven) > 8.0


def test_equal_arguments_give_equal_drives_and_seeds_differ(scenario_world: Places) -> None:
    world = scenario_world("demo", 0)
    config = DriveConfig(duration_s=12.0)
    robot = WheeledRobot(world)
    first, again, other = (roll_out(robot, world, config, seed) for seed in (3, 3, 4))
    for name in ("position_m", "quaternion", "command", "intervention"):
        assert getattr(first, name).tobytes() == getattr(again, name).tobytes()
    assert first.imu.values.tobytes() == again.imu.values.tobytes()
    assert first.failures == again.failures
    assert not np.array_equal(first.position_m[0], other.position_m[0])
    assert first.duration_s == pytest.approx(12.0)


def test_random_drives_vary_their_speed_and_turn_within_their_limits(scenario_world: Places) -> None:
    world = scenario_world("graspe_1", 0)
    config = DriveConfig(duration_s=40.0, speed_mps=[0.3, 0.7], turn_radps=0.6, wander=0.8)
    command = roll_out(WheeledRobot(world), world, config, 11).command
    assert command[:, 0].max() <= 0.7
    assert np.abs(command[:, 1]).max() <= 0.6 + 1e-9
    assert len(np.unique(command[:, 0].round(2))) > 8
    assert command[:, 1].min() < -0.1 < 0.1 < command[:, 1].max()


@pytest.mark.slow
def test_a_careless_driver_gets_into_more_trouble(scenario_world: Places) -> None:
    world = scenario_world("graspe_1", 0)
    robot = WheeledRobot(world)

    def failed(config: DriveConfig) -> float:
        return float(np.mean([roll_out(robot, world, config, seed).failed_share for seed in range(3)]))

    careful = failed(DriveConfig(duration_s=20.0, careful=1.0))
    careless = failed(DriveConfig(duration_s=20.0, careful=0.0, mischief=1.0))
    assert careful < 0.05 < careless


@pytest.mark.slow
def test_the_operator_frees_what_tall_grass_holds(scenario_world: Places) -> None:
    world = scenario_world("graspe_3", 0)
    robot = WheeledRobot(world)
    config = DriveConfig(careful=0.0, mischief=0.9)
    freed = 0
    for seed in range(3):
        drive = roll_out(robot, world, config, seed)
        for failure in drive.failures:
            if failure.kind is FailureKind.entangled and failure.end_s < 55.0:
                after = (drive.time_s > failure.start_s) & (drive.time_s < failure.end_s + 1.0)
                freed += int(drive.intervention[after].any())
    assert freed > 0


@pytest.mark.parametrize("name", ["demo", "mim_1", "graspe_4"])
def test_a_course_leads_from_start_to_goal_without_a_blow(name: str, scenario_world: Places) -> None:
    world = scenario_world(name, 1)
    drive = roll_out(WheeledRobot(world), world, DriveConfig(driver=DriverKind.course, duration_s=120.0), 0)
    assert np.hypot(*(drive.position_m[-1, :2] - world.goal_m)) < 0.4
    assert drive.duration_s < 119.0
    assert not [failure for failure in drive.failures if failure.kind is FailureKind.collision]


def test_a_script_gives_its_orders_and_then_goes_through_its_points(scenario_world: Places) -> None:
    world = scenario_world("mim_2", 0)
    x, y = world.start_m
    config = DriveConfig(
        driver=DriverKind.script,
        orders=[Order(duration_s=1.0, speed_mps=0.3), Order(duration_s=0.5)],
        waypoints=[Waypoint(x_m=x + 1.2, y_m=y), Waypoint(x_m=x + 1.2, y_m=y + 0.6)],
        speed_mps=[0.4, 0.4],
        start=PoseConfig(x_m=x, y_m=y),
    )
    drive = roll_out(WheeledRobot(world), world, config, 0)
    np.testing.assert_array_equal(drive.command[1:101], np.tile([0.3, 0.0], (100, 1)))
    np.testing.assert_array_equal(drive.command[101:151], 0.0)
    assert drive.command[151:, 0].max() == pytest.approx(0.4, abs=1e-6)
    assert np.hypot(*(drive.position_m[-1, :2] - [x + 1.2, y + 0.6])) < 0.45
    assert drive.duration_s < 30.0


def test_drives_that_cannot_be_are_refused(scenario_world: Places) -> None:
    world = scenario_world("demo", 0)
    robot = WheeledRobot(world)
    trunk = next(item for item in world.obstacles.items if item.kind == "trunk")
    with pytest.raises(SimError, match="inside or against"):
        roll_out(robot, world, DriveConfig(start=PoseConfig(x_m=trunk.x_m, y_m=trunk.y_m)), 0)
    with pytest.raises(SimError, match="seed is -1"):
        roll_out(robot, world, DriveConfig(), -1)


@pytest.mark.parametrize(
    ("wrong", "what"),
    [
        ({"duration_s": 0.0}, "duration_s"),
        ({"mischief": 1.5}, "mischief"),
        ({"careful": -0.1}, "careful"),
        ({"speed_mps": [0.5]}, "speed_mps"),
        ({"speed_mps": [0.9, 0.5]}, "speed_mps"),
        ({"turn_radps": 0.0}, "turn_radps"),
        ({"driver": DriverKind.script}, "neither orders nor waypoints"),
        ({"orders": [Order(duration_s=1.0)]}, "only driver=script"),
    ],
)
def test_wrong_settings_name_themselves(wrong: dict[str, object], what: str) -> None:
    with pytest.raises(SettingError, match=what):
        DriveConfig(**wrong)  # type: ignore[arg-type]
    with pytest.raises(SettingError, match="0 s"):
        Order(duration_s=0.0)


def test_settings_come_through_structured_configs() -> None:
    given = {"driver": "script", "orders": [{"duration_s": 2.0, "speed_mps": 0.5}], "start": {"x_m": 1.0}}
    made = OmegaConf.to_object(OmegaConf.merge(OmegaConf.structured(DriveConfig), OmegaConf.create(given)))
    order = Order(duration_s=2.0, speed_mps=0.5)
    assert made == DriveConfig(driver=DriverKind.script, orders=[order], start=PoseConfig(x_m=1.0))
