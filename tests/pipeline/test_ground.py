"""Pixels and places on the ground: round trips, the horizon, and a pinhole worked by hand."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from navtool.pipeline.geometry.camera import CameraModel
from navtool.pipeline.geometry.ground import ground_from_pixels, pixels_from_ground
from navtool.pipeline.geometry.transforms import transform_from_xyz_rpy

OPTICAL = np.array([[0.0, 0, 1, 0], [-1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 0, 1]])
CAMERA = CameraModel(640, 480, 400.0, 400.0, 319.5, 239.5)
BARREL = CameraModel(640, 480, 400.0, 400.0, 319.5, 239.5, "plumb_bob", (-0.28, 0.07, 0.001, -0.0007))


def mounted(height_m: float, pitch_rad: float, yaw_rad: float = 0.0) -> NDArray[np.float64]:
    """The optical frame's pose of a camera at that height above the base frame, looking down by the pitch."""
    pose = transform_from_xyz_rpy(np.array([0.2, 0.0, height_m]), np.array([0.0, pitch_rad, yaw_rad]))
    return np.asarray(pose @ OPTICAL)


def test_the_image_centre_sees_where_the_axis_meets_the_ground() -> None:
    ground = ground_from_pixels(np.array([[319.5, 239.5]]), CAMERA, mounted(1.0, np.pi / 4), base_height_m=0.5)
    np.testing.assert_allclose(ground.xy, [[0.2 + 1.5, 0.0]], atol=1e-9)
    assert ground.valid.all()


@settings(deadline=None, max_examples=60)
@given(
    x=st.floats(0.8, 30), sideways=st.floats(-0.6, 0.6), pitch=st.floats(0, 0.6), yaw=st.floats(-0.2, 0.2),
    height=st.floats(0.2, 1.5), base_height=st.floats(0, 0.5), barrel=st.booleans(),
)  # fmt: skip
def test_places_survive_the_image(
    x: float, sideways: float, pitch: float, yaw: float, height: float, base_height: float, barrel: bool
) -> None:
    camera, pose = BARREL if barrel else CAMERA, mounted(height, pitch, yaw)
    xy = np.array([[x, sideways * x]])
    seen = pixels_from_ground(xy, camera, pose, base_height)
    if not seen.in_front.all():
        return
    ground = ground_from_pixels(seen.pixels, camera, pose, base_height)
    assert ground.valid.all()
    np.testing.assert_allclose(ground.xy, xy, rtol=1e-4, atol=1e-6)


def test_nothing_at_or_above_the_horizon_is_ground() -> None:
    level = mounted(0.7, 0.0)
    rows = np.array([[319.5, 100.0], [319.5, 239.5], [319.5, 239.6], [100.0, 400.0]])
    ground = ground_from_pixels(rows, CAMERA, level)
    np.testing.assert_array_equal(ground.valid, [False, False, True, True])
    assert np.isnan(ground.xy[:2]).all()
    assert ground.xy[2, 0] > 1000


@pytest.mark.parametrize("height_m", [0.0, -0.3])
def test_a_camera_on_or_under_the_ground_sees_none_of_it(height_m: float) -> None:
    ground = ground_from_pixels(np.array([[319.5, 400.0]]), CAMERA, mounted(height_m, 0.2))
    assert not ground.valid.any()
