"""How the robot moves: it tracks commands, lies on the ground, and never is inside what is solid."""

from collections.abc import Callable

import numpy as np
import pytest

from navtool.base.setting_error import SettingError
from navtool.pipeline.arrays import Array
from navtool.pipeline.geometry.transforms import quaternion_to_rpy
from navtool.sim.drive.vehicle import Vehicle
from navtool.sim.errors import SimError
from navtool.sim.wheeled.config import BASE_HEIGHT_M, STEP_S, WheeledConfig
from navtool.sim.wheeled.robot import WheeledRobot
from navtool.sim.wheeled.samples import Samples
from navtool.sim.world.obstacle import Obstacle, Obstacles
from navtool.sim.world.place import World
from navtool.sim.world.surfaces import surface_number

Place = Callable[..., World]
Run = Callable[..., WheeledRobot]

POLE = Obstacle(kind="pillar", surface=surface_number("steel"), x_m=2.0, y_m=0.1, half_length_m=0.04, height_m=2.0)
PANE = Obstacle(
    kind="glass",
    surface=surface_number("glass"),
    x_m=2.0,
    y_m=0.0,
    half_length_m=0.8,
    half_width_m=0.006,
    yaw_rad=1.3,
    height_m=2.0,
)
ROCK = Obstacle(kind="rock", surface=surface_number("rock"), x_m=-2.0, y_m=0.6, half_length_m=0.5, height_m=0.4)


def overlap(samples: Samples, things: list[Obstacle], config: WheeledConfig) -> float:
    """How deep the footprint's area reaches into outlines at worst, by points 1 cm apart: an oracle of its own."""
    along = np.linspace(-config.half_length_m, config.half_length_m, 100)
    across = np.linspace(-config.half_width_m, config.half_width_m, 68)
    u, v = (axis.ravel() for axis in np.meshgrid(along, across))
    worst = np.inf
    for x, y, yaw in samples.rows[::10, [0, 1, 5]].tolist():
        cos, sin = np.cos(yaw), np.sin(yaw)
        worst = min(
            worst, float(Obstacles(tuple(things)).clearance(x + cos * u - sin * v, y + sin * u + cos * v).min())
        )
    return worst


def test_it_is_a_vehicle(place: Place) -> None:
    vehicle: Vehicle = WheeledRobot(place())
    state = vehicle.reset(0.0, 0.0, 4.0)
    assert (state.time_s, state.speed_mps, state.touches, state.held, state.fallen) == (0.0, 0.0, None, False, False)
    assert state.yaw_rad == pytest.approx(4.0 - 2 * np.pi)
    assert vehicle.step(0.5, 0.0, 0.1).time_s == pytest.approx(0.1)


@pytest.mark.parametrize(("speed", "turn"), [(0.8, 0.0), (0.6, 0.4), (-0.5, 0.3), (0.0, 0.8), (1.0, -0.6)])
def test_on_level_concrete_it_tracks_the_command_on_the_analytic_arc(
    speed: float, turn: float, place: Place, run: Run
) -> None:
    samples = run(place(), (8.0, speed, turn)).samples()
    np.testing.assert_allclose(samples.speed_mps[200:], speed, atol=2e-3)
    np.testing.assert_allclose(samples.turn_radps[200:], turn, atol=2e-3)
    x, y, yaw = samples.rows[:, [0, 1, 5]].T
    since = samples.time_s[200:] - samples.time_s[200]
    if turn:
        radius = speed / turn
        ahead, left = radius * np.sin(turn * since), radius * (1 - np.cos(turn * since))
    else:
        ahead, left = speed * since, 0 * since
    cos, sin = np.cos(yaw[200]), np.sin(yaw[200])
    np.testing.assert_allclose(x[200:], x[200] + cos * ahead - sin * left, atol=0.02)
    np.testing.assert_allclose(y[200:], y[200] + sin * ahead + cos * left, atol=0.02)


def test_it_starts_no_faster_than_its_drives_allow(place: Place, run: Run) -> None:
    samples = run(place(), (2.0, 1.0, 0.0)).samples()
    faster = np.diff(samples.speed_mps) / STEP_S
    assert 1.5 < faster.max() <= 3.0 + 1e-6
    assert samples.speed_mps[10] < 0.3


def test_a_command_beyond_the_limits_is_limited(place: Place, run: Run) -> None:
    samples = run(place(), (3.0, 9.0, 0.0)).samples()
    assert samples.speed_mps.max() == pytest.approx(1.0, abs=0.01)
    assert samples.command[-1, 0] == 1.0


def test_equal_calls_give_equal_drives_bit_by_bit(place: Place) -> None:
    robot = WheeledRobot(place("gravel", lambda x, y: 0.05 * np.sin(3 * x) * np.cos(2 * y), [ROCK]))
    again = WheeledRobot(place("gravel", lambda x, y: 0.05 * np.sin(3 * x) * np.cos(2 * y), [ROCK]))
    again.reset(3.0, 3.0, 1.0)
    again.step(0.5, -0.5, 1.0)
    drives = []
    for one in (robot, again):
        one.reset(0.0, 0.0, 2.8)
        for turn in (0.0, 0.3, -0.4):
            one.step(0.7, turn, 2.0)
        drives.append(one.drive(7))
    for name in ("position_m", "quaternion", "velocity_mps", "rates_radps", "command", "intervention"):
        assert getattr(drives[0], name).tobytes() == getattr(drives[1], name).tobytes(), name
    for name in ("imu", "joints", "odometry", "battery"):
        for ours, theirs in zip(getattr(drives[0], name), getattr(drives[1], name), strict=True):
            assert ours.tobytes() == theirs.tobytes(), name
    assert drives[0].failures == drives[1].failures
    assert robot.drive(8).imu.values.tobytes() != drives[0].imu.values.tobytes()


@pytest.mark.parametrize("yaw", [0.0, 0.7, np.pi / 2, 3.0])
def test_on_an_inclined_plane_it_lies_in_the_plane(yaw: float, place: Place, run: Run) -> None:
    rise_x, rise_y = 0.12, -0.08
    world = place("concrete", lambda x, y: rise_x * x + rise_y * y)
    samples = run(world, (4.0, 0.5, 0.1), start=(0.0, 0.0, yaw)).samples()
    x, y, z = samples.ground_m.T
    np.testing.assert_allclose(z, rise_x * x + rise_y * y, atol=4e-3)
    normal = np.array([-rise_x, -rise_y, 1.0]) / np.sqrt(1 + rise_x**2 + rise_y**2)
    up = (samples.position_m() - samples.ground_m) / BASE_HEIGHT_M
    np.testing.assert_allclose(up, np.tile(normal, (len(up), 1)), atol=4e-3)


def test_it_climbs_what_its_drives_and_its_tyres_allow(place: Place, run: Run) -> None:
    def climbed(surface: str, rise: float) -> float:
        world = place(surface, lambda x, _: rise * np.clip(x, 0.0, 8.0))
        return float(run(world, (10.0, 0.6, 0.0), start=(0.6, 0.0, 0.0)).samples().ground_m[-1, 0])

    config = WheeledConfig()
    steepest = np.tan(np.arcsin(2 * config.side_force_n / (config.mass_kg * 9.81)))
    assert climbed("concrete", 0.85 * steepest) > 4.0
    assert climbed("concrete", 1.1 * steepest) < 1.0
    assert climbed("mud", 0.02) > 4.0
    assert climbed("mud", 0.2) < 1.0


def test_it_slips_more_the_steeper_it_climbs_and_slides_where_it_cannot_grip(place: Place, run: Run) -> None:
    def slip(surface: str, rise: float) -> float:
        world = place(surface, lambda x, _: rise * np.clip(x, 0.0, 8.0))
        samples = run(world, (4.0, 0.5, 0.0), start=(0.6, 0.0, 0.0)).samples()
        return float(1 - samples.speed_mps[-100:].mean() / samples.wheel_mps[-100:].mean())

    assert 0 <= slip("gravel", 0.0) < slip("gravel", 0.15) < slip("gravel", 0.3) < 0.1
    assert slip("mud", 0.2) > 0.9


@pytest.mark.parametrize("thing", [POLE, PANE, ROCK], ids=lambda thing: thing.kind)
def test_it_never_is_inside_what_is_solid(thing: Obstacle, place: Place) -> None:
    robot = WheeledRobot(place(things=[thing]))
    rng = np.random.default_rng(3)
    touched = 0
    for _ in range(6):
        away = rng.uniform(0, 2 * np.pi)
        x, y = thing.x_m + 2 * np.cos(away), thing.y_m + 2 * np.sin(away)
        robot.reset(float(x), float(y), float(away + np.pi + rng.normal(0.0, 0.07)))
        robot.step(float(rng.uniform(0.4, 1.0)), 0.0, 4.0)
        for _ in range(8):
            robot.step(float(rng.uniform(-1, 1)), float(rng.uniform(-1.5, 1.5)), 0.8)
        samples = robot.samples()
        touched += int((samples.obstacle >= 0).any())
        assert overlap(samples, [thing], robot.config) >= 0.0
    assert touched >= 5


def test_it_slides_along_a_wall_that_it_meets_at_a_small_angle(place: Place, run: Run) -> None:
    wall = Obstacle(
        kind="wall",
        surface=surface_number("brick"),
        x_m=0.0,
        y_m=1.0,
        half_length_m=6.0,
        half_width_m=0.1,
        height_m=2.0,
    )
    samples = run(place(things=[wall]), (6.0, 0.6, 0.0), start=(-4.0, 0.4, 0.25)).samples()
    assert (samples.obstacle >= 0).any()
    assert samples.ground_m[-1, 0] > -1.5
    assert abs(samples.rpy_rad[-1, 2]) < 0.03


def test_what_yields_lets_it_through(place: Place, run: Run) -> None:
    leaves = Obstacle(
        kind="hanging_leaves", surface=surface_number("leaf"), x_m=2.0, y_m=0.0, half_length_m=1.0, height_m=3.0
    )
    samples = run(place(things=[leaves]), (6.0, 0.8, 0.0)).samples()
    assert samples.ground_m[-1, 0] > 4.0
    assert (samples.obstacle < 0).all()


def test_it_tips_over_a_cliff_and_stays_down(place: Place, run: Run) -> None:
    def cliff(x: Array, _: Array) -> Array:
        return np.where(x > 2.0, -1.5, 0.0)

    robot = run(place("concrete", cliff), (6.0, 0.8, 0.0))
    state = robot.step(0.8, 0.0, 0.1)
    assert state.fallen
    samples = robot.samples()
    lies = samples.ground_m[samples.fallen]
    assert (lies == lies[0]).all()
    assert np.abs(quaternion_to_rpy(samples.quaternion())[-1, :2]).max() > 0.8


def test_it_refuses_places_and_steps_that_make_no_sense(place: Place) -> None:
    robot = WheeledRobot(place(things=[ROCK]))
    with pytest.raises(SimError, match="reset it first"):
        robot.step(0.1, 0.0, 0.1)
    with pytest.raises(SimError, match="inside or against a rock"):
        robot.reset(-2.3, 0.0, 0.0)
    robot.reset(0.0, 0.0, 0.0)
    with pytest.raises(SimError, match="no drive has happened"):
        robot.drive(0)
    for duration in (0.0, 0.01, 0.03, 0.005, -1.0):
        with pytest.raises(SimError, match=r"multiple of 0\.02 s"):
            robot.step(0.1, 0.0, duration)
    with pytest.raises(SettingError, match="mass_kg"):
        WheeledConfig(mass_kg=0.0)
