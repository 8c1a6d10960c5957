import dataclasses

import mujoco
import numpy as np
import pytest

from navtool.pipeline.arrays import Array
from navtool.sim.legged.footings import concrete
from navtool.sim.legged.ground import LIMB_WIDTHS_M
from navtool.sim.legged.robot import LeggedRobot
from navtool.sim.legged.stems import SLIP_RAD, bending_n, stem_rigidity_n
from navtool.sim.world.mesh import TriangleMesh, join_meshes, make_mesh, repeated_faces
from navtool.sim.world.place import make_world
from navtool.sim.world.scenario import Scatter, ScenarioConfig
from navtool.sim.world.surfaces import surface_number
from navtool.sim.world.vegetation import BLADES_PER_M2


def test_a_stem_resists_with_the_work_of_a_bent_cantilever() -> None:
    rigidity, height, width, stems = 0.02, 0.3, 0.05, 400.0
    push = np.linspace(0.0, 2 * rigidity * SLIP_RAD / height**2, 1001)  # up to the slope at which it slips
    deflection = push * height**3 / (3 * rigidity)
    work = np.trapezoid(push, deflection)
    assert bending_n(stems * rigidity, width, height) == pytest.approx(stems * width * work)


def upright(spacing_m: float, height_m: float) -> TriangleMesh:
    """A stand of upright blades of one height, three triangles each as in places, evenly over 4 m x 4 m."""
    axis = (np.arange(round(4.0 / spacing_m)) + 0.5) * spacing_m - 2.0
    x, y = (values.ravel() for values in np.meshgrid(axis, axis))
    feet = np.column_stack([x, y, np.zeros_like(x)])
    side, up = np.array([0.0025, 0.0, 0.0]), np.array([0.0, 0.0, height_m])
    corners = np.stack([feet - side, feet + side, feet - side + 0.6 * up, feet + side + 0.6 * up, feet + up], axis=1)
    faces = repeated_faces([[0, 1, 3], [0, 3, 2], [2, 3, 4]], 5, len(feet))
    return make_mesh(corners, faces, surface_number("tall_grass"))


def rigidity_of(*stands: TriangleMesh) -> Array:
    """What the stands of an otherwise bare place have, by cell of its ground."""
    bare = make_world(ScenarioConfig(name="bare", side_m=24.0, course_m=12.0), 0)
    return stem_rigidity_n(dataclasses.replace(bare, mesh=join_meshes([bare.mesh, *stands])))


def test_a_dense_stand_one_metre_high_is_as_stiff_as_those_that_were_measured() -> None:
    found = rigidity_of(upright(BLADES_PER_M2**-0.5, 1.0))
    cell_m, middle = 24.0 / len(found), len(found) // 2
    assert found.sum() * cell_m**2 == pytest.approx(319.0 * 16.0, rel=0.01)
    assert np.median(found[middle - 9 : middle + 9, middle - 9 : middle + 9]) == pytest.approx(319.0, rel=0.2), "evenly"


def test_blades_of_a_stand_add_up() -> None:
    low, high = upright(0.2, 0.4), upright(0.31, 0.8)
    assert rigidity_of(low, high) == pytest.approx(rigidity_of(low) + rigidity_of(high))
    assert rigidity_of(low, low) == pytest.approx(2 * rigidity_of(low))
    assert rigidity_of(low).sum() > 0


def test_grass_twice_as_high_is_ten_times_as_stiff_and_there_is_none_where_none_grows() -> None:
    config = ScenarioConfig(name="meadow", side_m=24.0, course_m=12.0, grass_patches=Scatter(count=4, gap_m=-1.0))
    world = make_world(config, 3)
    found = stem_rigidity_n(world)
    taller = world.mesh._replace(vertices=world.mesh.vertices * np.array([1, 1, 2], np.float32))
    assert stem_rigidity_n(dataclasses.replace(world, mesh=taller)) == pytest.approx(9.849 * found, rel=1e-3)
    axis = (np.arange(len(found)) + 0.5 - len(found) / 2) * world.ground.cell_m
    x, y = np.meshgrid(axis, axis)
    far = world.obstacles.clearance(x, y) > 0.7
    assert (found[far] == 0.0).all()
    assert (found > 0.0).any()


@pytest.mark.parametrize("speed_mps", [0.2, 0.5, 1.0])
def test_stems_hold_a_limb_alike_at_any_speed_but_never_push_it(speed_mps: float) -> None:
    robot = LeggedRobot(dataclasses.replace(concrete(), stems_n=20.0, cover_m=5.0))
    data = robot.data
    data.qvel[0] = speed_mps
    mujoco.mj_forward(robot.model, data)
    data.xfrc_applied[:] = 0.0
    held = robot.ground.hold(data)
    limbs = data.xfrc_applied[robot.ground.limbs, 0]
    assert (limbs < 0).all()
    assert held == pytest.approx(-limbs.sum())
    heights = data.xipos[robot.ground.limbs, 2]
    most = [bending_n(20.0, width, height) for width, height in zip(LIMB_WIDTHS_M, heights, strict=True)]
    assert -limbs == pytest.approx(most, rel=0.35), "met in its middle, a little short of it where it would be stopped"
    data.qvel[:] = 0.0
    assert robot.ground.hold(data) == 0.0
    assert robot.ground.hold(data, freed=True) == 0.0
