import mujoco
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from navtool.pipeline.arrays import Array
from navtool.sim.legged.body import HIPS_M, JOINT_HIGH_RAD, JOINT_LOW_RAD, LEGS, SIDES, build
from navtool.sim.legged.leg_kinematics import (
    LONGEST_M,
    SHORTEST_M,
    foot_in_leg,
    foot_velocity_in_leg,
    joints_for_foot,
)

LOW, HIGH = JOINT_LOW_RAD[:3], JOINT_HIGH_RAD[:3]
sides = st.sampled_from([1.0, -1.0])
share = st.floats(0.02, 0.98)


def foot(angles: Array, side: float) -> Array:
    return np.asarray(foot_in_leg(angles[None], np.array([side]))[0])


@given(share, share, share, sides)
def test_the_angles_that_a_foot_asks_for_bring_it_there(a: float, b: float, c: float, side: float) -> None:
    angles = LOW + np.array([a, b, c]) * (HIGH - LOW)
    place = foot(angles, side)
    x, y, z = place.tolist()
    found = np.array(joints_for_foot(x, y, z, side))
    down = place[2] * np.cos(angles[0]) - place[1] * np.sin(angles[0])
    if down < -0.05:  # above the hip two poses reach the same place
        assert found == pytest.approx(angles, abs=1e-9)
    assert (found >= LOW - 1e-12).all()
    assert (found <= HIGH + 1e-12).all()


@given(st.floats(-2, 2), st.floats(-2, 2), st.floats(-2, 2), sides)
def test_any_place_gives_angles_within_the_ranges(x: float, y: float, z: float, side: float) -> None:
    found = np.array(joints_for_foot(x, y, z, side))
    assert (found >= LOW - 1e-12).all()
    assert (found <= HIGH + 1e-12).all()


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_foot_out_of_reach_is_stretched_towards(side: float) -> None:
    place = foot(np.array(joints_for_foot(0.3, 0.110945 * side, -2.0, side)), side)
    assert np.hypot(place[0], place[2]) == pytest.approx(LONGEST_M, abs=1e-9)
    assert place[0] / -place[2] == pytest.approx(0.15, abs=1e-9)
    assert 0.0 < SHORTEST_M < 0.15
    assert 0.6 < LONGEST_M < 0.66


def test_places_and_velocities_equal_the_physics() -> None:
    model = build()
    data = mujoco.MjData(model)
    rng = np.random.default_rng(3)
    jacobian = np.zeros((3, model.nv))
    for _ in range(20):
        data.qpos[7:] = rng.uniform(JOINT_LOW_RAD, JOINT_HIGH_RAD)
        data.qvel[6:] = rng.normal(0.0, 3.0, 12)
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        angles, rates = data.qpos[7:].reshape(4, 3), data.qvel[6:].reshape(4, 3)
        places = HIPS_M + foot_in_leg(angles, SIDES)
        velocities = foot_velocity_in_leg(angles, rates, SIDES)
        for leg, name in enumerate(LEGS):
            site = model.site(f"{name}_foot").id
            mujoco.mj_jacSite(model, data, jacobian, None, site)
            assert places[leg] + data.qpos[:3] == pytest.approx(data.site_xpos[site], abs=1e-12)
            assert velocities[leg] == pytest.approx(jacobian @ data.qvel, abs=1e-12)
