import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from navtool.pipeline.arrays import Array
from navtool.sim.legged.body import LEGS, MASS_KG, build
from navtool.sim.legged.felt_grip import FIRM, LEAST
from navtool.sim.legged.stance import LEAST_N, MOST_N, ground_forces

WEIGHT = MASS_KG * 9.81


@pytest.fixture(scope="module")
def jacobian() -> Array:
    """The Jacobian of a standing robot's feet."""
    model = build()
    data = mujoco.MjData(model)
    data.qpos[7:] = np.tile([0.0, 0.78, -1.5], 4)
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    rows = np.zeros((12, model.nv))
    for leg, name in enumerate(LEGS):
        mujoco.mj_jacSite(model, data, rows[3 * leg : 3 * leg + 3], None, model.site(f"{name}_foot").id)
    return rows


def test_four_feet_give_what_is_wanted(jacobian: Array) -> None:
    wanted = np.array([20.0, -10.0, WEIGHT, 3.0, -4.0, 2.0])
    forces = ground_forces(jacobian, wanted, [1.0] * 4, FIRM)
    assert jacobian[:, :6].T @ forces == pytest.approx(wanted, abs=6.0)
    assert jacobian[:, :6].T @ forces != pytest.approx(wanted, abs=1e-9), "torque has a price"


@settings(max_examples=60)
@given(
    st.lists(st.floats(-1, 1), min_size=6, max_size=6),
    st.lists(st.floats(0, 1), min_size=4, max_size=4),
    st.floats(LEAST, FIRM),
)
def test_forces_push_within_the_friction_cone_and_only_where_a_foot_stands(
    jacobian: Array, share: list[float], trust: list[float], friction: float
) -> None:
    wrench = np.array(share) * [300, 300, 600, 150, 150, 150]
    forces = ground_forces(jacobian, wrench, trust, friction).reshape(4, 3)
    for force, trusted in zip(forces, trust, strict=True):
        if trusted == 0.0:
            assert force.tolist() == [0.0, 0.0, 0.0]
        else:
            assert LEAST_N <= force[2] <= MOST_N
            assert np.hypot(*force[:2]) <= friction * force[2] * (1 + 1e-9)


def test_a_foot_hands_its_load_on_as_trust_in_it_fades(jacobian: Array) -> None:
    wanted = np.array([0.0, 0.0, WEIGHT, 0.0, 0.0, 0.0])
    load = [ground_forces(jacobian, wanted, [trust, 1.0, 1.0, 1.0], FIRM)[2] for trust in (0.05, 0.2, 0.5, 1.0)]
    assert (np.diff(load) > 0).all()
    assert load[0] < 0.25 * load[-1]
