import dataclasses

import mujoco
import numpy as np
import pytest

from navtool.sim.legged.footings import concrete
from navtool.sim.legged.ground import LIMB_WIDTHS_M
from navtool.sim.legged.robot import LeggedRobot
from navtool.sim.legged.stems import SLIP_RAD, bending_n, stem_rigidity_n
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


def test_grass_is_as_stiff_as_its_blades_together() -> None:
    config = ScenarioConfig(name="meadow", side_m=24.0, course_m=12.0, grass_patches=Scatter(count=4, gap_m=-1.0))
    world = make_world(config, 3)
    found = stem_rigidity_n(world)
    corners = world.mesh.vertices[world.mesh.triangles[world.mesh.surface == surface_number("tall_grass")]]
    whole = 0.0
    for blade in corners.astype(np.float64).reshape(-1, 9, 3):
        whole += 319.0 * (blade[:, 2].max() - blade[:, 2].min()) ** 3.3 / BLADES_PER_M2
    assert found.sum() * world.ground.cell_m**2 == pytest.approx(whole)
    axis = (np.arange(len(found)) + 0.5 - len(found) / 2) * world.ground.cell_m
    x, y = np.meshgrid(axis, axis)
    far = world.obstacles.clearance(x, y) > 0.7
    assert (found[far] == 0.0).all()


@pytest.mark.parametrize("speed_mps", [0.2, 0.5, 1.0])
def test_stems_hold_a_limb_alike_at_any_speed_but_never_push_it(speed_mps: float) -> None:
    robot = LeggedRobot(dataclasses.replace(concrete(), stems_n=20.0, cover_m=5.0))
    data = robot._data
    data.qvel[0] = speed_mps
    mujoco.mj_forward(robot._model, data)
    data.xfrc_applied[:] = 0.0
    held = robot._ground.hold(data)
    limbs = data.xfrc_applied[robot._ground._limbs, 0]
    assert (limbs < 0).all()
    assert held == pytest.approx(-limbs.sum())
    heights = data.xipos[robot._ground._limbs, 2]
    most = [bending_n(20.0, width, height) for width, height in zip(LIMB_WIDTHS_M, heights, strict=True)]
    assert -limbs == pytest.approx(most, rel=0.35), "met in its middle, a little short of it where it would be stopped"
    data.qvel[:] = 0.0
    assert robot._ground.hold(data) == 0.0
    assert robot._ground.hold(data, freed=True) == 0.0
