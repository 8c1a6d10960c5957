import mujoco
import numpy as np
import pytest

from navtool.sim.errors import SimError
from navtool.sim.legged.body import (
    HIP_TORQUE_NM,
    JOINT_HIGH_RAD,
    JOINT_LOW_RAD,
    JOINT_NAMES,
    MASS_KG,
    build,
    knee_torque_limit,
    torque_limit,
)
from navtool.sim.legged.obstacle import Form, Obstacle


def test_the_model_has_the_published_mass_joints_and_ranges() -> None:
    model = build()
    assert float(model.body_mass.sum()) == pytest.approx(MASS_KG)
    assert tuple(model.joint(i + 1).name for i in range(12)) == JOINT_NAMES
    assert np.allclose(model.jnt_range[1:], np.stack([JOINT_LOW_RAD, JOINT_HIGH_RAD], axis=-1))
    assert np.degrees(JOINT_HIGH_RAD[2] - JOINT_LOW_RAD[2]) == pytest.approx(146.0, abs=0.1), "14 to 160 degrees"


def test_it_is_as_long_and_wide_as_published_when_it_stands() -> None:
    model = build()
    data = mujoco.MjData(model)
    data.qpos[7:] = np.tile([0.0, 0.78, -1.5], 4)
    mujoco.mj_kinematics(model, data)
    limbs = [i for i in range(model.ngeom) if model.geom_type[i] == mujoco.mjtGeom.mjGEOM_CAPSULE]
    place, radius = data.geom_xpos[limbs], model.geom_size[limbs, 0]
    assert 2 * (np.abs(place[:, 1]) + radius).max() == pytest.approx(0.42, abs=0.08), "published: 0.5 m"
    trunk = model.geom("trunk").id
    assert 0.8 < 2 * model.geom_size[trunk, 0] < 1.1, "published: 1.1 m with what sticks out in front"


def test_every_body_can_exist() -> None:
    inertia = build().body_inertia[1:]
    moving = inertia[inertia.min(axis=1) > 0]
    assert len(moving) == 13
    largest = moving.max(axis=1)
    assert (largest <= moving.sum(axis=1) - largest + 1e-12).all(), "triangle inequality of moments of inertia"


def test_the_knee_is_strongest_in_the_middle_and_the_hips_always_the_same() -> None:
    angle = np.linspace(-2.79, -0.25, 200)
    limit = knee_torque_limit(angle)
    assert -1.6 < angle[np.argmax(limit)] < -1.3
    assert limit.min() > 30.0
    assert limit.max() < 1.5 * 76.0, "motor torque times the largest ratio"
    assert np.allclose(np.delete(torque_limit(np.tile(angle[:1], 12)), [2, 5, 8, 11]), HIP_TORQUE_NM)


def test_an_obstacle_without_size_is_refused() -> None:
    with pytest.raises(SimError, match="tree has size"):
        Obstacle(name="tree", form=Form.CYLINDER, centre_m=(0.0, 0.0, 0.0), size_m=(0.2, 0.0, 0.0))
    Obstacle(name="stone", form=Form.BALL, centre_m=(0.0, 0.0, 0.0), size_m=(0.2, 0.0, 0.0))
