"""Rigid transforms: group laws, round trips, and SciPy as the oracle."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation, Slerp

from navtool.pipeline.geometry.transforms import (
    apply_transform,
    invert_transform,
    quaternion_from_rpy,
    quaternion_from_transform,
    quaternion_to_rpy,
    rpy_from_transform,
    slerp,
    transform_from_xyz_quaternion,
    transform_from_xyz_rpy,
    wrap_angle,
    yaw_from_quaternion,
)

Floats = NDArray[np.float64]

coordinate = st.floats(-100, 100)
component = st.floats(-1, 1)
points = st.lists(coordinate, min_size=3, max_size=3).map(np.array)
quaternions = st.lists(component, min_size=4, max_size=4).map(np.array).filter(lambda q: bool(np.linalg.norm(q) > 1e-3))


@st.composite
def transforms(draw: st.DrawFn) -> Floats:
    return transform_from_xyz_quaternion(draw(points), draw(quaternions))


@settings(deadline=None)
@given(first=transforms(), second=transforms(), point=points)
def test_applying_a_product_is_applying_both(first: Floats, second: Floats, point: Floats) -> None:
    both = apply_transform(first @ second, point[None])
    np.testing.assert_allclose(both, apply_transform(first, apply_transform(second, point[None])), atol=1e-9)


@settings(deadline=None)
@given(transform=transforms(), point=points)
def test_inverse_undoes_and_distances_stay(transform: Floats, point: Floats) -> None:
    np.testing.assert_allclose(invert_transform(transform) @ transform, np.eye(4), atol=1e-12)
    pair = np.stack([point, np.zeros(3)])
    moved = apply_transform(transform, pair)
    assert np.linalg.norm(moved[0] - moved[1]) == pytest.approx(np.linalg.norm(point), abs=1e-9)


@settings(deadline=None)
@given(quaternion=quaternions)
def test_rotation_agrees_with_scipy(quaternion: Floats) -> None:
    ours = transform_from_xyz_quaternion(np.zeros(3), quaternion)
    np.testing.assert_allclose(ours[:3, :3], Rotation.from_quat(quaternion).as_matrix(), atol=1e-12)


@settings(deadline=None)
@given(quaternion=quaternions)
def test_quaternion_survives_matrix_and_angles(quaternion: Floats) -> None:
    matrix = transform_from_xyz_quaternion(np.zeros(3), quaternion)
    back = quaternion_from_transform(matrix)
    assert back[3] >= 0
    assert np.linalg.norm(back) == pytest.approx(1)
    np.testing.assert_allclose(transform_from_xyz_quaternion(np.zeros(3), back), matrix, atol=1e-12)
    # Also where roll and yaw turn about the same axis.
    angles = quaternion_from_rpy(rpy_from_transform(matrix))
    np.testing.assert_allclose(transform_from_xyz_quaternion(np.zeros(3), angles), matrix, atol=1e-8)


@settings(deadline=None)
@given(roll=st.floats(-3.1, 3.1), pitch=st.floats(-1.5, 1.5), yaw=st.floats(-3.1, 3.1))
def test_angles_survive_the_quaternion(roll: float, pitch: float, yaw: float) -> None:
    rpy = np.array([roll, pitch, yaw])
    quaternion = quaternion_from_rpy(rpy)
    np.testing.assert_allclose(quaternion_to_rpy(quaternion), rpy, atol=1e-9)
    assert yaw_from_quaternion(quaternion) == pytest.approx(yaw, abs=1e-9)
    expected = Rotation.from_euler("xyz", rpy).as_matrix()
    np.testing.assert_allclose(transform_from_xyz_rpy(np.zeros(3), rpy)[:3, :3], expected, atol=1e-12)


@pytest.mark.parametrize("pitch", [np.pi / 2, -np.pi / 2])
def test_gimbal_lock_keeps_the_rotation_with_roll_zero(pitch: float) -> None:
    rpy = np.array([0.4, pitch, 1.1])
    back = quaternion_to_rpy(quaternion_from_rpy(rpy))
    assert back[0] == 0
    np.testing.assert_allclose(
        transform_from_xyz_rpy(np.zeros(3), back), transform_from_xyz_rpy(np.zeros(3), rpy), atol=1e-7
    )


@settings(deadline=None)
@given(first=quaternions, second=quaternions, fraction=st.floats(0, 1))
def test_slerp_agrees_with_scipy(first: Floats, second: Floats, fraction: float) -> None:
    ends = Rotation.from_quat([first, second])
    if (ends[0].inv() * ends[1]).magnitude() > np.pi - 1e-3:
        return  # opposite rotations: no way is the shorter one
    ours = Rotation.from_quat(slerp(first, second, np.array(fraction)))
    assert (ours.inv() * Slerp([0, 1], ends)(fraction)).magnitude() < 1e-7


@settings(deadline=None)
@given(first=quaternions, second=quaternions)
def test_slerp_hits_its_ends_and_ignores_signs(first: Floats, second: Floats) -> None:
    start, end = Rotation.from_quat(first), Rotation.from_quat(second)
    at_ends = slerp(np.stack([first, first]), np.stack([second, -second]), np.array([0.0, 1.0]))
    assert (Rotation.from_quat(at_ends[0]).inv() * start).magnitude() < 1e-7
    assert (Rotation.from_quat(at_ends[1]).inv() * end).magnitude() < 1e-7


def test_slerp_of_nearly_equal_rotations_stays_exact() -> None:
    tiny = np.array([0.0, 0.0, 1e-12, 1.0])
    half = slerp(np.array([0.0, 0.0, 0.0, 1.0]), tiny, np.array(0.5))
    assert half[2] == pytest.approx(0.5e-12, rel=1e-6)


def test_leading_axes_are_independent(rng: np.random.Generator) -> None:
    xyz, rpy = rng.normal(size=(2, 5, 3)), rng.normal(size=(2, 5, 3))
    cloud = rng.normal(size=(2, 5, 7, 3))
    batch = transform_from_xyz_rpy(xyz, rpy)
    for place in np.ndindex(2, 5):
        one = transform_from_xyz_rpy(xyz[place], rpy[place])
        np.testing.assert_allclose(batch[place], one, atol=1e-15)
        np.testing.assert_allclose(apply_transform(batch, cloud)[place], apply_transform(one, cloud[place]))
        np.testing.assert_allclose(rpy_from_transform(batch)[place], rpy_from_transform(one), atol=1e-12)


def test_float32_points_stay_float32(rng: np.random.Generator) -> None:
    cloud = rng.uniform(-100, 100, (50, 3))
    transform = transform_from_xyz_rpy(np.array([0.3, 0.1, 0.5]), np.array([0.1, -0.2, 3.0]))
    moved = apply_transform(transform, cloud.astype(np.float32))
    assert moved.dtype == np.float32
    np.testing.assert_allclose(moved, apply_transform(transform, cloud), atol=5e-5)


@pytest.mark.parametrize("bad", [[0.0, 0.0, 0.0, 0.0], [np.nan, 0.0, 0.0, 1.0], [np.inf, 0.0, 0.0, 1.0]])
def test_a_quaternion_that_is_no_rotation_is_refused(bad: list[float]) -> None:
    quaternions_of_messages = np.array([[0.0, 0.0, 0.0, 1.0], bad])
    with pytest.raises(ValueError, match="1 of 2 quaternions"):
        transform_from_xyz_quaternion(np.zeros((2, 3)), quaternions_of_messages)


@settings(deadline=None)
@given(angle=st.floats(-100, 100), turns=st.integers(-5, 5))
def test_wrapping_drops_whole_turns(angle: float, turns: int) -> None:
    wrapped = wrap_angle(np.array([angle, angle + 2 * np.pi * turns]))
    assert (wrapped >= -np.pi).all()
    assert (wrapped < np.pi).all()
    np.testing.assert_allclose(np.exp(1j * wrapped), np.exp(1j * angle), atol=1e-9)


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(7)
