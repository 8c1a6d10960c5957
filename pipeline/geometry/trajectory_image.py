"""The trajectory that a velocity leads to, drawn into the camera's picture of the ground."""

from dataclasses import dataclass

import cv2
import numpy as np
from jaxtyping import Float, Float64, Int64, UInt8

from navtool.base.setting_checks import outside
from navtool.base.setting_error import refuse
from navtool.pipeline.arrays import Array
from navtool.pipeline.geometry.camera import CameraModel
from navtool.pipeline.geometry.clip_polygons import clip_to_disc, clip_to_half_space
from navtool.pipeline.geometry.transforms import apply_transform, invert_transform
from navtool.pipeline.geometry.unicycle import poses_after

_MAX_SAGITTA_M = 0.002
_STRIPS = 4
_DISTORTED_STRIPS = 20
_MOST_DOUBLINGS = 5
_DISTORTED_EDGE_POINTS = 5
_SUBPIXEL_BITS = 4
_PIXEL_LIMIT = 1e7


@dataclass(kw_only=True, slots=True)
class TrajectoryImageConfig:
    """What the drawn trajectory covers."""

    robot_width_m: float = 0.5
    """Width of the swath on the ground in metres, above 0."""
    horizon: int = 10
    """Number of time steps T, at least 1."""
    dt_s: float = 0.1
    """Time step in seconds, above 0."""
    near_m: float = 0.05
    """Ground nearer to the camera than this, in metres along its optical axis, is cut off; above 0."""

    def __post_init__(self) -> None:
        refuse(
            outside(self, 0, np.inf, "robot_width_m", "near_m", unit="m", above=True, below=True),
            outside(self, 0, np.inf, "dt_s", unit="s", above=True, below=True),
            outside(self, 1, np.inf, "horizon", unit="steps"),
        )


def trajectory_image(
    velocity: Float[Array, "2"],
    camera: CameraModel,
    base_camera: Float64[Array, "4 4"],
    config: TrajectoryImageConfig,
    *,
    height: int = 240,
    width: int = 320,
    base_height_m: float = 0.0,
) -> UInt8[Array, "{height} {width}"]:
    """The swath of one velocity [v_mps, omega_radps] as an image of 0 and 255; see `trajectory_images`."""
    images = trajectory_images(
        velocity[None], camera, base_camera, config, height=height, width=width, base_height_m=base_height_m
    )
    return np.asarray(images[0])


def trajectory_images(
    velocities: Float[Array, "n 2"],
    camera: CameraModel,
    base_camera: Float64[Array, "4 4"],
    config: TrajectoryImageConfig,
    *,
    height: int = 240,
    width: int = 320,
    base_height_m: float = 0.0,
) -> UInt8[Array, "n {height} {width}"]:
    """The swath of each velocity [v_mps, omega_radps] as the camera sees it on flat ground: 255 on it, 0 elsewhere.

    The swath is the ground that the robot's cross-section, a segment of the robot's width through the base frame's
    origin, passes over in T steps of dt at constant velocity. A robot that stands still passes over nothing: its image
    is empty. One that turns on the spot passes over a disc of its width, which a camera that looks ahead does not see.
    Reverse motion is drawn like any other, where the camera sees it.

    Args:
        velocities: Rows of [v_mps, omega_radps], of either sign, finite.
        camera: The camera's model at any image size; it is scaled to `width` x `height`.
        base_camera: Pose of the camera's optical frame (z forward, x right, y down) in the base frame.
        config: Width, horizon and time step.
        height: Image height in pixels.
        width: Image width in pixels.
        base_height_m: Height of the base frame's origin above the ground, which is the plane z = -base_height_m.

    Raises:
        ValueError: A velocity is not finite.

    Reference: GrASPE, IV-A: the extrapolated trajectory is "projected to a blank image using homography projection".

    Note:
        The homography of the ground plane follows from the camera's model and its pose on the robot, and the lens
        distortion is applied too. Obstacles do not hide the swath. The image of a row does not depend on the others.
    """
    if not np.isfinite(velocities).all():
        raise ValueError("a velocity is not finite: no trajectory follows from it")
    images = np.zeros((len(velocities), height, width), np.uint8)
    wide, scaled = velocities.astype(np.float64), camera.scaled_to(width, height)
    camera_base = invert_transform(base_camera)
    doublings = _doublings(wide, config, straight=scaled.is_ideal)
    for doubled in np.unique(doublings).tolist():
        rows = np.flatnonzero((doublings == doubled) & (wide != 0).any(axis=1))
        ground = _swath_polygons(wide[rows], config, doubled, straight=scaled.is_ideal)
        owner = np.repeat(rows, ground.shape[1])
        flat = ground.reshape(-1, 2)
        points = np.column_stack([flat, np.full(len(flat), -base_height_m)])
        optical = apply_transform(camera_base, points).reshape(len(owner), ground.shape[2], 3)
        pixels, owner = _project_polygons(optical, owner, scaled, config.near_m)
        _fill(images, pixels, owner)
    return images


def _doublings(
    velocities: Float64[Array, "n 2"], config: TrajectoryImageConfig, *, straight: bool
) -> Int64[Array, " n"]:
    """How often each row doubles the least number of strips, so that the chords of its arc stay near the arc."""
    speed, turn_rate = np.abs(velocities).T
    until = _until(turn_rate, config)
    # An arc of length s that turns by d rises s d / 8 above its chord; the outer edge of the swath is the longest.
    rise = (speed + turn_rate * config.robot_width_m / 2) * until * turn_rate * until / 8
    strips = np.sqrt(rise / _MAX_SAGITTA_M)
    # Where times are squared, the last strip is twice the mean.
    least = _STRIPS if straight else _DISTORTED_STRIPS / 2
    doublings: Array = np.clip(np.ceil(np.log2(np.maximum(strips / least, 1.0))), 0, _MOST_DOUBLINGS)
    return doublings.astype(np.int64)


def _until(turn_rate: Float64[Array, " n"], config: TrajectoryImageConfig) -> Float64[Array, " n"]:
    """The duration of each row's motion; after a whole turn the robot passes over the same ground again."""
    return np.minimum(config.horizon * config.dt_s, 2 * np.pi / np.maximum(turn_rate, 1e-9))


def _swath_polygons(
    velocities: Float64[Array, "n 2"], config: TrajectoryImageConfig, doubled: int, *, straight: bool
) -> Float64[Array, "n strips points 2"]:
    """The swath as strips between consecutive cross-sections: convex polygons (x, y) on the ground.

    Where the lens does not keep lines straight, the strips are shorter the nearer they are to the robot, and the
    cross-sections have points between their ends.
    """
    speed, turn_rate = np.abs(velocities).T
    half = config.robot_width_m / 2
    if straight:
        unit_times, edge_points = np.linspace(0.0, 1.0, (_STRIPS << doubled) + 1), 2
    else:
        unit_times = np.linspace(0.0, 1.0, (_DISTORTED_STRIPS << doubled) + 1) ** 2
        edge_points = _DISTORTED_EDGE_POINTS
    # Scaling both velocities by the duration lets all rows share one time axis.
    poses = poses_after(velocities * _until(turn_rate, config)[:, None], unit_times)
    leftward = half * np.stack([-np.sin(poses[..., 2]), np.cos(poses[..., 2])], axis=-1)
    left, right = poses[..., :2] + leftward, poses[..., :2] - leftward
    # Two consecutive cross-sections form an isosceles trapezoid. With the turning centre inside the robot's width they
    # cross, and are its diagonals: exchanging the left ends keeps the corners in order around it.
    crossing = (speed < turn_rate * half)[:, None, None]
    first_left = np.where(crossing, left[:, 1:], left[:, :-1])
    second_left = np.where(crossing, left[:, :-1], left[:, 1:])
    share = np.linspace(0.0, 1.0, edge_points)[:, None]
    near_edge = first_left[:, :, None] * (1 - share) + right[:, :-1, None] * share
    far_edge = right[:, 1:, None] * (1 - share) + second_left[:, :, None] * share
    return np.concatenate([near_edge, far_edge], axis=2)


def _project_polygons(
    optical: Float64[Array, "polygons points 3"],
    owner: Int64[Array, " polygons"],
    camera: CameraModel,
    near_m: float,
) -> tuple[Float64[Array, "visible corners 2"], Int64[Array, " visible"]]:
    """The polygons' parts within the camera's field in pixels, and which image each belongs to."""
    optical, kept = clip_to_half_space(optical, np.array([0.0, 0.0, 1.0]), near_m)
    owner = owner[kept]
    normalised = optical[..., :2] / optical[..., 2:]
    if np.isfinite(camera.max_radius):
        normalised, kept = clip_to_disc(normalised, 0.999 * camera.max_radius)
        owner = owner[kept]
    return camera.pixels_from_normalised(normalised.reshape(-1, 2)).reshape(normalised.shape), owner


def _fill(
    images: UInt8[Array, "n h w"],
    pixels: Float64[Array, "visible corners 2"],
    owner: Int64[Array, " visible"],
) -> None:
    """Fill the polygons into the images; a pixel that a polygon's outline touches belongs to it."""
    height, width = images.shape[1:]
    low, high = pixels.min(axis=1, initial=np.inf), pixels.max(axis=1, initial=-np.inf)
    inside = (high >= -1).all(axis=1) & (low <= (width, height)).all(axis=1)
    fixed = np.rint(np.clip(pixels[inside], -_PIXEL_LIMIT, _PIXEL_LIMIT) * (1 << _SUBPIXEL_BITS)).astype(np.int32)
    for index, corners in zip(owner[inside].tolist(), fixed, strict=True):
        cv2.fillPoly(images[index], [corners], 255, cv2.LINE_8, _SUBPIXEL_BITS)
