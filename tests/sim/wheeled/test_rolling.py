"""Energy and resistance: what is drawn is work and losses, and more resistance takes more."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from navtool.pipeline.arrays import Array
from navtool.sim.wheeled.config import GRAVITY_MPS2, STEP_S
from navtool.sim.wheeled.footing import BLADE_AREA, Footing, rolling_resistance
from navtool.sim.wheeled.robot import WheeledRobot
from navtool.sim.world.kinds import KINDS, Spot
from navtool.sim.world.mesh import TriangleMesh
from navtool.sim.world.place import World, make_world
from navtool.sim.world.scenario import Scatter, ScenarioConfig
from navtool.sim.world.surfaces import GROUND, SURFACES, surface_number

Place = Callable[..., World]
Run = Callable[..., WheeledRobot]
FROM, TO = 300, 900
GRASS = SURFACES[surface_number("tall_grass")]


def energy_j(robot: WheeledRobot) -> float:
    """Drawn for motion between two moments at a steady speed."""
    samples = robot.samples()
    return float((samples.power_w[FROM:TO] - robot.config.idle_w).sum() * STEP_S)


def test_rolling_resistance_orders_the_grounds_as_tables_of_wheels_do() -> None:
    resistance = {surface.name: float(value) for surface, value in zip(GROUND, rolling_resistance(), strict=False)}
    assert 0.01 < resistance["concrete"] < resistance["asphalt"] < 0.03
    assert resistance["asphalt"] < resistance["gravel"] < resistance["sand"] < resistance["mulch"] < resistance["mud"]
    assert 0.04 < resistance["gravel"] < 0.08
    assert 0.2 < resistance["mud"] < 0.3


def test_more_resistance_takes_more_energy(place: Place, run: Run) -> None:
    surfaces = ("concrete", "gravel", "grass", "sand", "mulch", "mud")
    drawn = [energy_j(run(place(surface), (10.0, 0.6, 0.0), start=(-5.0, 0.0, 0.0))) for surface in surfaces]
    assert drawn == sorted(drawn)
    assert drawn[0] > 0
    assert drawn[-1] > 4 * drawn[0]


def test_steeper_takes_more_and_turning_on_the_spot_takes_much(place: Place, run: Run) -> None:
    def up(rise: float) -> float:
        world = place("asphalt", lambda x, _: rise * (x + 12.0))
        return energy_j(run(world, (10.0, 0.6, 0.0), start=(-5.0, 0.0, 0.0)))

    climbs = [up(rise) for rise in (-0.1, 0.0, 0.05, 0.1, 0.2)]
    assert climbs == sorted(climbs)
    assert climbs[0] == 0.0
    straight = energy_j(run(place("asphalt"), (10.0, 0.6, 0.0), start=(-5.0, 0.0, 0.0)))
    spot = energy_j(run(place("asphalt"), (10.0, 0.0, 0.6)))
    assert spot > 3 * straight
    slippery = energy_j(run(place("sand"), (10.0, 0.0, 0.6)))
    assert slippery < spot


@pytest.mark.parametrize(("surface", "rise"), [("concrete", 0.0), ("sand", 0.0), ("gravel", 0.15), ("grass", -0.03)])
def test_what_is_drawn_is_work_and_losses(surface: str, rise: float, place: Place, run: Run) -> None:
    robot = run(place(surface, lambda x, _: rise * (x + 12.0)), (10.0, 0.7, 0.0), start=(-5.0, 0.0, 0.0))
    samples, config = robot.samples(), robot.config
    weight = config.mass_kg * GRAVITY_MPS2
    span = slice(FROM, TO)
    work_w = (samples.force_n * samples.wheel_mps)[span]
    heat_w = config.winding_loss_w_per_n2 * samples.force_n[span] ** 2
    drawn_w = config.idle_w + (heat_w + work_w / config.efficiency).sum(axis=1)
    np.testing.assert_allclose(samples.power_w[span], drawn_w)
    np.testing.assert_allclose(samples.lost_w[span], drawn_w - work_w.sum(axis=1))
    x, z = samples.ground_m[:, 0], samples.ground_m[:, 2]
    way = (x[TO] - x[FROM]) * np.hypot(1.0, rise)
    lift = weight * (z[TO] - z[FROM])
    number = surface_number(surface)
    rolls = float(rolling_resistance()[number]) * weight / np.hypot(1.0, rise) * way
    dragged = config.mass_kg * float(GROUND[number].drag_per_m * (samples.speed_mps[span] ** 3).sum()) * STEP_S
    slips = float(((samples.wheel_mps - samples.speed_mps[:, None]) * samples.force_n)[span].sum()) * STEP_S
    assert work_w.sum() * STEP_S == pytest.approx(lift + rolls + dragged + slips, rel=0.005)


def patch(size: float, density: int = 1) -> TriangleMesh:
    """Tall grass about 2, 0; density patches over each other."""
    meshes = [KINDS["grass_patches"].mesh(Spot(0, 0, 0, size, 0), np.random.default_rng(k)) for k in range(density)]
    vertices = np.concatenate([mesh.vertices for mesh in meshes])
    offset = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes[:-1])])
    triangles = np.concatenate([mesh.triangles + start for mesh, start in zip(meshes, offset, strict=True)])
    surface = np.concatenate([mesh.surface for mesh in meshes])
    return TriangleMesh(vertices + np.array([3.0, 0.0, 0.0], np.float32), triangles.astype(np.int32), surface)


def test_a_patch_of_tall_grass_drags_in_its_middle_as_its_surface_says() -> None:
    total, count = 0.0, 12
    for seed in range(count):
        mesh = KINDS["grass_patches"].mesh(Spot(0, 0, 0, 0.6, 0), np.random.default_rng(seed))
        corners = mesh.vertices[mesh.triangles].astype(np.float64)
        middle = np.hypot(*corners.mean(axis=1)[:, :2].T) < 0.8
        edges = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[middle]
        total += 0.5 * float(np.linalg.norm(edges, axis=1).sum()) / (np.pi * 0.8**2) / count
    assert total == pytest.approx(BLADE_AREA, rel=0.1)


def test_dense_grass_holds_it_and_thin_grass_only_slows_it(place: Place, run: Run) -> None:
    def through(mesh: TriangleMesh, *, freed: bool = False) -> tuple[float, bool]:
        robot = run(place("grass", mesh=mesh), (9.0, 0.6, 0.0), freed=freed)
        return float(robot.samples().ground_m[-1, 0]), bool(robot.samples().held.any())

    bare = through(TriangleMesh(np.zeros((3, 3), np.float32), np.zeros((0, 3), np.int32), np.zeros(0, np.uint8)))
    thin, thick = through(patch(0.3)), through(patch(0.9, density=4))
    assert not bare[1]
    assert not thin[1]
    assert thin[0] == pytest.approx(bare[0], abs=0.3)
    assert thick[1]
    assert thick[0] < 4.5
    freed = through(patch(0.9, density=4), freed=True)
    assert freed[0] == pytest.approx(bare[0], abs=0.3)
    assert not freed[1]


def test_grass_as_dense_as_its_surface_says_holds_it_after_about_three_metres(place: Place, run: Run) -> None:
    world = place("grass")
    drag = world.ground.drag_per_m.copy()
    drag[:, 120:] += GRASS.drag_per_m
    field = replace(world, ground=replace(world.ground, drag_per_m=drag))
    reached = float(run(field, (9.0, 0.6, 0.0), start=(-0.6, 0.0, 0.0)).samples().ground_m[-1, 0])
    assert 2.3 < reached < 4.0


def test_grass_drags_most_where_patches_overlap() -> None:
    config = ScenarioConfig(name="meadow", side_m=24.0, course_m=12.0, grass_patches=Scatter(count=12, gap_m=-1.0))
    world = make_world(config, 3)
    footing = Footing(world)
    rng = np.random.default_rng(0)
    x, y = rng.uniform(-9, 9, (2, 3000))
    plants: Array = np.array([footing.at(*at)[6] for at in zip(x.tolist(), y.tolist(), strict=True)])
    inside = (world.obstacles.distances(x, y) < -0.3).sum(axis=0)
    near = world.obstacles.clearance(x, y) < 0.6
    assert plants[inside == 2].mean() > 1.5 * plants[inside == 1].mean() > 0
    assert (plants[~near] == 0).all()
