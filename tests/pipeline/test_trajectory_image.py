"""The drawn trajectory: the exact swath pixel by pixel as the oracle, symmetries, and what a camera cannot see."""

from functools import cache

import cv2
import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from navtool.base.setting_error import SettingError
from navtool.pipeline.geometry.camera import CameraModel
from navtool.pipeline.geometry.ground import GroundPoints, ground_from_pixels, pixels_from_ground
from navtool.pipeline.geometry.trajectory_image import TrajectoryImageConfig, trajectory_image, trajectory_images
from navtool.pipeline.geometry.transforms import transform_from_xyz_rpy
from navtool.pipeline.geometry.unicycle import poses_after

Floats = NDArray[np.float64]
Image = NDArray[np.uint8]

OPTICAL = np.array([[0.0, 0, 1, 0], [-1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 0, 1]])
CAMERAS = {
    "ideal": CameraModel(640, 480, 400.0, 400.0, 319.5, 239.5),
    "barrel": CameraModel(640, 480, 400.0, 400.0, 319.5, 239.5, "plumb_bob", (-0.3, 0.09, 0.001, -0.001, 0.0)),
    "folding": CameraModel(640, 480, 330.0, 330.0, 319.5, 239.5, "plumb_bob", (-0.3, 0.0, 0.0, 0.0, 0.0)),
    "fisheye": CameraModel(640, 480, 250.0, 250.0, 319.5, 239.5, "equidistant", (-0.01, 0.01, -0.005, 0.001)),
}
CONFIG = TrajectoryImageConfig(robot_width_m=0.6, horizon=10, dt_s=0.3)
PIXELS = np.stack(np.meshgrid(np.arange(320.0), np.arange(240.0)), axis=-1).reshape(-1, 2)
STRAIGHT, LEFT, RIGHT = np.array([1.0, 0.0]), np.array([0.9, 0.4]), np.array([0.9, -0.4])


def mounted(height_m: float = 0.6, pitch_rad: float = 0.35, x_m: float = 0.1) -> Floats:
    """The optical frame's pose of a camera that looks ahead and down."""
    pose = transform_from_xyz_rpy(np.array([x_m, 0.0, height_m]), np.array([0.0, pitch_rad, 0.0]))
    return np.asarray(pose @ OPTICAL)


def on_swath(xy: Floats, velocity: Floats, config: TrajectoryImageConfig) -> NDArray[np.bool_]:
    """Whether the cross-section passes over each place: exact, in polar coordinates about the turning centre."""
    speed, turn_rate = velocity.tolist()
    duration, half = config.horizon * config.dt_s, config.robot_width_m / 2
    if turn_rate == 0:
        way = sorted((0.0, speed * duration))
        return np.asarray((np.abs(xy[:, 1]) <= half) & (xy[:, 0] >= way[0]) & (xy[:, 0] <= way[1]) & (speed != 0))
    radius, turned = speed / turn_rate, turn_rate * duration
    x, y = xy[:, 0], xy[:, 1] - radius
    distance = np.hypot(x, y)
    found = np.zeros(len(xy), np.bool_)
    for signed in (distance, -distance):
        angle = np.arctan2(np.sign(signed) * x, -np.sign(signed) * y)
        along = np.mod(angle * np.sign(turned), 2 * np.pi) <= abs(turned)
        found |= along & (np.abs(signed - radius) <= half)
    return found


@cache
def ground_of_pixels(camera: CameraModel, base_camera: tuple[float, ...]) -> GroundPoints:
    """The ground place that the centre of each pixel of a 320x240 image sees."""
    return ground_from_pixels(PIXELS, camera.scaled_to(320, 240), np.array(base_camera).reshape(4, 4))


@cache
def seen_by(camera: CameraModel) -> Image:
    """The pixels at least 2 pixels within the lens's image circle."""
    valid = camera.scaled_to(320, 240).rays(PIXELS).valid.reshape(240, 320)
    return np.asarray(cv2.erode(np.where(valid, 255, 0).astype(np.uint8), np.ones((5, 5), np.uint8)), np.uint8)


def exact(velocity: Floats, camera: CameraModel, base_camera: Floats, config: TrajectoryImageConfig) -> Image:
    """The image from the ground place that each pixel's centre sees."""
    ground = ground_of_pixels(camera, tuple(base_camera.reshape(-1).tolist()))
    inside = np.zeros(len(ground.valid), np.bool_)
    inside[ground.valid] = on_swath(ground.xy[ground.valid], velocity, config)
    return np.where(inside, 255, 0).astype(np.uint8).reshape(240, 320)


def assert_same_outline(drawn: Image, expected: Image, seen: Image | None = None) -> None:
    """Nothing is missing a pixel inside the expected outline, nothing is drawn more than two pixels outside of it."""
    everywhere = np.full_like(drawn, 255) if seen is None else seen
    core = cv2.erode(expected, np.ones((3, 3), np.uint8), borderValue=255)
    assert not (np.asarray(core, np.uint8) & ~drawn & everywhere).any()
    assert_within(drawn & everywhere, expected)


def assert_within(drawn: Image, covering: Image) -> None:
    """Nothing is drawn more than two pixels outside of the other image, of which the border hides what lies beyond."""
    assert not (drawn & ~grown(covering, 5))[2:-2, 2:-2].any()


def grown(image: Image, size: int) -> Image:
    return np.asarray(cv2.dilate(image, np.ones((size, size), np.uint8)), np.uint8)


@pytest.mark.parametrize("lens", sorted(CAMERAS))
@pytest.mark.parametrize(
    "velocity",
    [(1.0, 0.0), (0.9, 0.4), (0.9, -0.4), (0.2, 0.9), (0.4, -3.0), (0.05, 2.5), (0.0, 1.0), (-1.0, 0.2), (2.5, 0.05)],
)
def test_agrees_with_the_exact_swath(lens: str, velocity: tuple[float, float]) -> None:
    camera, base_camera = CAMERAS[lens], mounted()
    ours = trajectory_image(np.array(velocity), camera, base_camera, CONFIG)
    assert_same_outline(ours, exact(np.array(velocity), camera, base_camera, CONFIG), seen_by(camera))


@pytest.mark.parametrize("x_m", [-1.2, -0.4])
@pytest.mark.parametrize("velocity", [(1.0, 0.3), (-0.8, 0.0), (-0.8, 0.5), (0.0, 2.0)])
def test_a_camera_behind_the_origin_sees_turns_and_reverse_motion(x_m: float, velocity: tuple[float, float]) -> None:
    base_camera = mounted(0.9, 0.7, x_m)
    ours = trajectory_image(np.array(velocity), CAMERAS["ideal"], base_camera, CONFIG)
    expected = exact(np.array(velocity), CAMERAS["ideal"], base_camera, CONFIG)
    assert expected.any()
    assert_same_outline(ours, expected)


@settings(deadline=None, max_examples=40)
@given(
    speed=st.floats(0.3, 2.0), turn_rate=st.floats(-0.8, 0.8),
    height=st.floats(0.3, 1.2), pitch=st.floats(0.0, 0.6), lens=st.sampled_from(sorted(CAMERAS)),
)  # fmt: skip
@example(speed=0.30078125, turn_rate=0.375, height=0.30078125, pitch=0.30078125, lens="folding")  # at the lens's rim
def test_the_centre_line_lies_in_the_swath(
    speed: float, turn_rate: float, height: float, pitch: float, lens: str
) -> None:
    velocity, base_camera = np.array([speed, turn_rate]), mounted(height, pitch)
    image = trajectory_image(velocity, CAMERAS[lens], base_camera, CONFIG)
    way = poses_after(velocity, np.linspace(0.01, 2.99, 60))[:, :2]
    pixels, in_front = pixels_from_ground(way, CAMERAS[lens].scaled_to(320, 240), base_camera)
    column, row = np.rint(pixels[in_front]).astype(int).T
    shown = (column >= 0) & (column < 320) & (row >= 0) & (row < 240)
    # Far away the swath is thinner than a pixel's rounding.
    near = grown(image, 3)
    assert (near[row[shown], column[shown]] == 255).all()


def test_turns_show_on_their_side_and_mirror_each_other() -> None:
    left, right, straight = trajectory_images(np.stack([LEFT, RIGHT, STRAIGHT]), CAMERAS["ideal"], mounted(), CONFIG)
    assert left[:, :160].sum() > left[:, 160:].sum()
    # The middle of the picture lies between two pixels, so a mirrored image is the other one up to its outline.
    assert_same_outline(right, np.ascontiguousarray(left[:, ::-1]))
    assert_same_outline(straight, np.ascontiguousarray(straight[:, ::-1]))
    assert not straight[:46].any()  # above the horizon


@settings(deadline=None, max_examples=30)
@given(speed=st.floats(-1.5, 1.5), turn_rate=st.floats(-2, 2), narrow=st.floats(0.1, 0.8), more=st.floats(0.0, 0.5))
def test_a_wider_robot_and_a_longer_horizon_cover_more(
    speed: float, turn_rate: float, narrow: float, more: float
) -> None:
    velocity, camera, base_camera = np.array([speed, turn_rate]), CAMERAS["barrel"], mounted()
    small = TrajectoryImageConfig(robot_width_m=narrow, horizon=8, dt_s=0.2)
    wide = TrajectoryImageConfig(robot_width_m=narrow + more, horizon=8, dt_s=0.2)
    long = TrajectoryImageConfig(robot_width_m=narrow, horizon=12, dt_s=0.2)
    image = trajectory_image(velocity, camera, base_camera, small)
    for covering in (wide, long):
        assert_within(image, trajectory_image(velocity, camera, base_camera, covering))


def test_standing_still_is_empty_and_creeping_is_nearly() -> None:
    base_camera = mounted(0.9, 0.9, -0.4)  # sees the ground under the robot
    images = trajectory_images(np.array([[0.0, 0.0], [1e-6, 0.0], [0.1, 0.0]]), CAMERAS["ideal"], base_camera, CONFIG)
    assert not images[0].any()
    assert (images[1] > 0).sum() < 0.02 * (images[2] > 0).sum() + 400
    assert images[2].any()


def test_turning_on_the_spot_is_out_of_sight_ahead() -> None:
    assert not trajectory_image(np.array([0.0, 1.0]), CAMERAS["ideal"], mounted(x_m=0.3), CONFIG).any()


def test_rows_are_independent_and_sizes_scale() -> None:
    rng = np.random.default_rng(5)
    velocities = np.column_stack([rng.uniform(-0.5, 2, 30), rng.uniform(-1.5, 1.5, 30)])
    batch = trajectory_images(velocities, CAMERAS["barrel"], mounted(), CONFIG)
    assert set(np.unique(batch)) == {0, 255}
    for velocity, image in zip(velocities, batch, strict=True):
        np.testing.assert_array_equal(trajectory_image(velocity, CAMERAS["barrel"], mounted(), CONFIG), image)
    small = trajectory_image(LEFT, CAMERAS["barrel"], mounted(), CONFIG, height=120, width=160)
    shrunk = cv2.resize(trajectory_image(LEFT, CAMERAS["barrel"], mounted(), CONFIG), (160, 120))
    assert_same_outline(small, np.where(shrunk > 127, 255, 0).astype(np.uint8))


def test_the_base_frame_may_lie_above_the_ground() -> None:
    low = trajectory_image(LEFT, CAMERAS["ideal"], mounted(0.6), CONFIG)
    raised = trajectory_image(LEFT, CAMERAS["ideal"], mounted(0.4), CONFIG, base_height_m=0.2)
    np.testing.assert_array_equal(low, raised)


def test_a_camera_that_looks_up_sees_nothing() -> None:
    assert not trajectory_image(STRAIGHT, CAMERAS["ideal"], mounted(0.6, -1.2), CONFIG).any()
    assert trajectory_images(np.zeros((0, 2)), CAMERAS["ideal"], mounted(), CONFIG).shape == (0, 240, 320)


@pytest.mark.parametrize("bad", [{"robot_width_m": 0.0}, {"dt_s": -0.1}, {"near_m": float("nan")}, {"horizon": 0}])
def test_bad_settings_are_reported(bad: dict[str, float]) -> None:
    with pytest.raises(SettingError, match=next(iter(bad))):
        TrajectoryImageConfig(**bad)  # type: ignore[arg-type] # a horizon of 0 is the point


def test_a_velocity_that_is_no_number_is_refused() -> None:
    with pytest.raises(ValueError, match="not finite"):
        trajectory_image(np.array([np.nan, 0.0]), CAMERAS["ideal"], mounted(), CONFIG)
