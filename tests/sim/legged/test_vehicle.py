"""The quadruped in a world: its drives, and that it meets what the world says is there."""

import dataclasses
import math

import mujoco
import numpy as np
import pytest

from navtool.sim.drive.config import DriveConfig, DriverKind
from navtool.sim.drive.drive import Drive
from navtool.sim.drive.failure import FailureKind
from navtool.sim.drive.make import roll_out
from navtool.sim.drive.script import Order
from navtool.sim.drive.vehicle import Vehicle
from navtool.sim.errors import SimError
from navtool.sim.legged.body import FOOT_RADIUS_M, MASS_KG, STEP_S
from navtool.sim.legged.gaits import GAITS, GaitName
from navtool.sim.legged.robot import LeggedRobot
from navtool.sim.legged.terrain import Terrain
from navtool.sim.legged.vehicle import LeggedVehicle
from navtool.sim.legged.world_footing import LOOSE_M, REFERENCE_MPS, WINDING, WorldFooting
from navtool.sim.legged.world_obstacles import world_obstacles
from navtool.sim.world.height_field import HeightField
from navtool.sim.world.kinds import KINDS, Spot
from navtool.sim.world.mesh import join_meshes
from navtool.sim.world.obstacle import Obstacle, Obstacles
from navtool.sim.world.place import World, make_world
from navtool.sim.world.scenario import Scatter, ScenarioConfig
from navtool.sim.world.surfaces import SURFACES, surface_number

SIDE_M = 24.0


def level(ground: str = "concrete", *obstacles: Obstacle) -> World:
    """A small level place of one ground with things in it; tall grass in its middle is as dense as there are of it."""
    world = make_world(ScenarioConfig(name="level", ground=ground, side_m=SIDE_M, course_m=16.0), 0)
    drag = np.full(world.ground.surface.shape, SURFACES[surface_number(ground)].drag_per_m, np.float32)
    axis = (np.arange(len(drag)) + 0.5) * world.ground.cell_m - SIDE_M / 2
    x, y = np.meshgrid(axis, axis)
    for item in obstacles:
        inside = Obstacles((item,)).clearance(x, y) < 0
        drag[inside] = np.maximum(drag[inside], SURFACES[item.surface].drag_per_m)
    heights = np.zeros_like(world.ground.heights_m)
    field = HeightField(cell_m=world.ground.cell_m, heights_m=heights, surface=world.ground.surface, drag_per_m=drag)
    grass = [item for item in obstacles if item.surface == surface_number("tall_grass")]
    blades = [
        KINDS["grass_patches"].mesh(Spot(0, item.x_m, item.y_m, 1.0, 0), np.random.default_rng(number))
        for number, item in enumerate(grass)
    ]
    mesh = join_meshes(
        [world.mesh, *(one.moved(item.x_m, item.y_m, 0.0) for one, item in zip(blades, grass, strict=True))]
    )
    return dataclasses.replace(
        world, mesh=mesh, ground=field, obstacles=Obstacles(obstacles), start_m=(-8.0, 0.0), goal_m=(8.0, 0.0)
    )


def thing(kind: str, surface: str, x_m: float, size_m: float, height_m: float) -> Obstacle:
    number = surface_number(surface)
    return Obstacle(kind=kind, surface=number, x_m=x_m, y_m=0.0, half_length_m=size_m, height_m=height_m)


def same(first: Drive, second: Drive) -> bool:
    """Whether two drives are equal to the bit."""
    plain = ("time_s", "position_m", "quaternion", "velocity_mps", "rates_radps", "command", "intervention")
    streams = ("imu", "joints", "odometry", "battery")
    return (
        all(np.array_equal(getattr(first, name), getattr(second, name)) for name in plain)
        and all(
            np.array_equal(a, b)
            for name in streams
            for a, b in zip(getattr(first, name), getattr(second, name), strict=True)
        )
        and (first.gait, first.failures) == (second.gait, second.failures)
    )


@pytest.fixture(scope="module")
def park() -> World:
    """A rough place with a bit of everything."""
    few = Scatter(count=4)
    config = ScenarioConfig(
        name="park",
        ground="rock_bed",
        side_m=SIDE_M,
        course_m=16.0,
        trees=few,
        bushes=few,
        rocks=few,
        walls=Scatter(count=1),
        glass_panels=Scatter(count=1),
        grass_patches=few,
    )
    return make_world(config, 3)


def test_a_drive_is_complete_and_its_streams_have_their_times() -> None:
    vehicle: Vehicle = LeggedVehicle(level())
    for _ in range(20):
        state = vehicle.step(0.5, 0.1, 0.1)
    drive = vehicle.drive(1)
    assert drive.time_s[0] == 0.0
    assert np.diff(drive.time_s) == pytest.approx(np.full(1000, STEP_S))
    assert drive.duration_s == pytest.approx(state.time_s) == pytest.approx(2.0)
    assert drive.position_m[0, :2] == pytest.approx([-8.0, 0.0])
    assert drive.position_m[-1, :2] == pytest.approx([state.x_m, state.y_m])
    assert drive.velocity_mps[-1, 0] == pytest.approx(state.speed_mps)
    assert drive.command[1:].tolist() == [[0.5, 0.1]] * 1000
    assert drive.failures == ()
    for stream, rate_hz, first_s in (
        (drive.imu, 250, 0.0),
        (drive.joints, 250, 0.0),
        (drive.odometry, 50, 0.0),
        (drive.battery, 10, 0.1),
    ):
        assert stream.time_s[0] == pytest.approx(first_s)
        assert np.diff(stream.time_s) == pytest.approx(np.full(len(stream.time_s) - 1, 1 / rate_hz))
        assert stream.time_s[-1] == pytest.approx(2.0)
        assert len(stream.values) == len(stream.time_s)


def test_the_truths_velocity_is_the_derivative_of_its_pose_in_the_bodys_axes() -> None:
    vehicle = LeggedVehicle(level())
    vehicle.reset(0.0, 0.0, 1.0)
    vehicle.step(0.5, 0.4, 3.0)
    drive = vehicle.drive(1)
    pose = drive.pose(drive.time_s)
    moved = np.gradient(drive.position_m, drive.time_s, axis=0)
    in_body = np.einsum("nji,nj->ni", pose[:, :3, :3], moved)
    assert np.abs(in_body - drive.velocity_mps)[10:-10].mean() < 0.01
    assert drive.velocity_mps[-500:, 0].mean() == pytest.approx(0.5, rel=0.05)


def test_the_same_calls_give_the_same_drive_and_a_reset_forgets_everything(park: World) -> None:
    drives = []
    vehicle = LeggedVehicle(park)
    for _ in range(2):
        vehicle.reset(*park.start_m, 0.3)
        vehicle.step(0.4, 0.1, 0.4)
        vehicle.set_gait(GaitName.CRAWL)
        vehicle.step(0.3, 0.0, 0.4, freed=True)
        drives.append(vehicle.drive(7))
    assert same(*drives)
    assert drives[0].gait == ((0.0, "trot"), (0.4, "crawl"))
    assert drives[0].intervention[1:].tolist() == [False] * 200 + [True] * 200
    assert not np.array_equal(drives[0].imu.values, vehicle.drive(8).imu.values)


def test_a_gait_brings_its_own_speed_limit_until_the_reset() -> None:
    vehicle = LeggedVehicle(level(), GaitName.AMBLE)
    vehicle.set_gait(GaitName.CRAWL)
    assert vehicle.speed_limit_mps == GAITS[GaitName.CRAWL].top_speed_mps
    vehicle.reset(0.0, 0.0, 0.0)
    assert vehicle.speed_limit_mps == GAITS[GaitName.AMBLE].top_speed_mps
    vehicle.step(0.2, 0.0, 0.02)
    assert vehicle.drive(1).gait == ((0.0, "amble"),)


def test_a_foot_meets_the_height_of_the_world(park: World) -> None:
    rng = np.random.default_rng(1)
    places = rng.uniform(-SIDE_M / 2 - 1, SIDE_M / 2 + 1, (2000, 2))
    found = Terrain(WorldFooting(park)).height(places)
    assert found == pytest.approx(park.ground.height_at(places[:, 0], places[:, 1]), abs=1e-9)
    robot = LeggedRobot(WorldFooting(park), start=(*park.start_m, 0.0))
    robot.step(0.0, 0.0, 1.0)
    feet = robot.samples().foot_m()[-1]
    depth = park.ground.height_at(feet[:, 0], feet[:, 1]) + FOOT_RADIUS_M - feet[:, 2]
    assert (depth < 0.012).all(), "it sinks in by its load over the stiffness, no further"
    assert (depth > -0.012).all(), "it rests on the ground, or on a stone's edge beside its lowest point"


def test_the_ground_holds_as_the_world_says(park: World) -> None:
    rng = np.random.default_rng(2)
    x, y = rng.uniform(-SIDE_M / 2, SIDE_M / 2, (2, 500))
    grip = WorldFooting(park).grip_at(x, y)
    surfaces = [SURFACES[number] for number in park.ground.surface_at(x, y).tolist()]
    assert grip.friction == pytest.approx([surface.friction for surface in surfaces], rel=1e-6)
    assert grip.stiffness_npm == pytest.approx([surface.stiffness_npm for surface in surfaces], rel=1e-6)
    assert grip.damping_nspm == pytest.approx([surface.damping_nspm for surface in surfaces], rel=1e-6)
    holds = (grip.drag_nspm2 > 0) | (grip.stems_n > 0)
    assert holds.any()
    assert not holds[park.ground.drag_at(x, y) == 0].any()
    assert np.array_equal(grip.cover_m > 0, holds)


@pytest.mark.parametrize(
    ("ground", "plant", "winding"), [("concrete", "bush_leaf", WINDING), ("mud", None, 1.0), ("sand", None, 1.0)]
)
def test_at_the_reference_speed_a_standing_robot_is_held_as_a_coasting_body(
    ground: str, plant: str | None, winding: float
) -> None:
    things = [] if plant is None else [thing("patch", plant, 0.0, 3.0, 0.9)]
    robot = LeggedRobot(WorldFooting(level(ground, *things)))
    data = robot.data
    data.qvel[0] = REFERENCE_MPS
    mujoco.mj_forward(robot.model, data)
    held_n = robot.ground.hold(data)
    share_per_m = SURFACES[surface_number(plant or ground)].drag_per_m
    assert held_n == pytest.approx(winding * MASS_KG * share_per_m * REFERENCE_MPS**2, rel=0.12)
    assert robot.ground.hold(data, freed=True) == 0.0


def test_the_cover_ends_where_the_plants_end() -> None:
    footing = WorldFooting(level("sand", thing("patch", "tall_grass", 0.0, 1.0, 0.9)))
    grip = footing.grip_at(np.array([0.8, 1.2]), np.zeros(2))
    assert grip.cover_m.tolist() == [0.9, LOOSE_M]
    assert (grip.stems_n > 0).tolist() == [True, False]


def test_tall_grass_slows_it_and_costs_current_unless_it_is_freed() -> None:
    went, drawn_w = [], []
    patch = thing("patch", "tall_grass", 0.0, 2.2, 0.9)
    for things, freed in (((), False), ((patch, patch), True), ((patch, patch), False)):
        vehicle = LeggedVehicle(level("concrete", *things))
        vehicle.reset(-1.0, 0.0, 0.0)
        state = vehicle.step(0.5, 0.0, 2.0, freed=freed)
        battery = vehicle.drive(1).battery.values
        went.append(state.x_m)
        drawn_w.append(-float((battery[:, 0] * battery[:, 1])[10:].mean()))
    assert went[1] == went[0]
    assert went[2] < went[0] - 0.02
    assert drawn_w[2] > drawn_w[0] + 10.0


def test_grass_that_is_dense_enough_holds_it_and_thinner_grass_does_not() -> None:
    patch = thing("patch", "tall_grass", 0.0, 2.2, 0.9)
    held = []
    for dense in (1, 6):
        vehicle = LeggedVehicle(level("grass", *(patch,) * dense))
        vehicle.reset(-2.0, 0.0, 0.0)
        held.append(any(vehicle.step(0.5, 0.0, 0.2).held for _ in range(30)))
    assert held == [False, True]


def test_what_takes_most_of_its_speed_holds_it() -> None:
    robot = LeggedRobot(WorldFooting(level("concrete", thing("thicket", "bush_leaf", 0.0, 3.5, 0.9))))
    assert not robot.state().held
    assert robot.step(0.4, 0.0, 3.0).held
    assert not robot.step(0.4, 0.0, 3.0, freed=True).held


def test_solid_things_stand_where_they_are_and_yielding_ones_do_not(park: World) -> None:
    solid = world_obstacles(park)
    items = park.obstacles.only(pliable=False).items
    assert [item.name for item in solid] == [item.kind for item in items]
    assert {"trunk", "bush", "rock", "wall", "glass"} == {item.name for item in solid}
    for body, item in zip(solid, items, strict=True):
        x, y, z = body.centre_m
        assert (x, y, body.yaw_rad) == (item.x_m, item.y_m, item.yaw_rad)
        top = z + (body.size_m[1] if item.half_width_m is None else body.size_m[2])
        ground = float(park.ground.height_at(np.array([x]), np.array([y]))[0])
        assert top - ground == pytest.approx(item.height_m)


def test_no_obstacle_overlaps_the_start_of_any_place(park: World) -> None:
    for seed in range(4):
        world = make_world(park.config, seed)
        vehicle = LeggedVehicle(world)
        state = vehicle.step(0.0, 0.0, 0.02)
        assert (state.x_m, state.y_m) == pytest.approx(world.start_m, abs=0.01)
        ahead = np.subtract(world.goal_m, world.start_m)
        assert state.yaw_rad == pytest.approx(math.atan2(ahead[1], ahead[0]), abs=0.01)
    trunk = park.obstacles.only(pliable=False).items[0]
    with pytest.raises(SimError, match=f"inside {trunk.kind}"):
        vehicle.reset(trunk.x_m, trunk.y_m, 0.0)


def test_it_walks_into_a_trunk_and_says_so() -> None:
    vehicle = LeggedVehicle(level("concrete", thing("trunk", "bark", -6.6, 0.2, 4.0)))
    touched = {vehicle.step(0.5, 0.0, 0.2).touches for _ in range(15)}
    assert touched == {None, "trunk"}
    first = vehicle.drive(1).failures[0]
    assert (first.kind, first.reason) == (FailureKind.collision, "against trunk")
    assert first.x_m == pytest.approx(-6.6 - 0.2 - 0.42, abs=0.08)


def test_a_fallen_robot_is_watched_for_a_second() -> None:
    world = level()
    heights = world.ground.heights_m.copy()
    heights[1:-1, 50:-1] = -1.0  # a cliff three metres ahead
    world = dataclasses.replace(world, ground=dataclasses.replace(world.ground, heights_m=heights))
    ahead = DriveConfig(driver=DriverKind.script, orders=[Order(duration_s=15.0, speed_mps=0.6)])
    drive = roll_out(LeggedVehicle(world), world, ahead, seed=1)
    fall = drive.failures[-1] if drive.failures[-1].kind is FailureKind.fall else drive.failures[0]
    assert fall.kind is FailureKind.fall
    assert drive.duration_s - fall.start_s == pytest.approx(1.0, abs=0.06)


def test_a_drive_needs_a_step() -> None:
    with pytest.raises(SimError, match="without a step"):
        LeggedVehicle(level()).drive(1)
