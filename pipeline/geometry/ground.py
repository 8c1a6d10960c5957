"""The flat ground under the robot: from pixels to places on it and back."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Float64

from navtool.pipeline.arrays import Array
from navtool.pipeline.geometry.camera import CameraModel, Projection
from navtool.pipeline.geometry.transforms import apply_transform, invert_transform

_MIN_DESCENT = 1e-9


class GroundPoints(NamedTuple):
    """Places on the ground that pixels see."""

    xy: Float64[Array, "n 2"]
    """(x, y) in the base frame in metres. NaN where not `valid`."""
    valid: Bool[Array, " n"]
    """The pixel looks down onto the ground: it is below the horizon and the lens sees it."""


def ground_from_pixels(
    pixels: Float[Array, "n 2"],
    camera: CameraModel,
    base_camera: Float64[Array, "4 4"],
    base_height_m: float = 0.0,
) -> GroundPoints:
    """The places on the ground plane that pixels see.

    Args:
        pixels: (u, v); the centre of the top left pixel is (0, 0).
        camera: Intrinsics for the image the pixels are of.
        base_camera: Pose of the camera's optical frame (z forward, x right, y down) in the base frame.
        base_height_m: Height of the base frame's origin above the ground, which is the plane z = -base_height_m.
    """
    rays = camera.rays(pixels)
    directions = rays.directions @ base_camera[:3, :3].T
    origin = base_camera[:3, 3]
    drop = origin[2] + base_height_m
    # A camera under the ground sees nothing of its upper side.
    valid = rays.valid & (directions[:, 2] < -_MIN_DESCENT) & (drop > 0)
    distance = np.where(valid, drop, np.nan) / np.where(valid, -directions[:, 2], 1.0)
    return GroundPoints(origin[:2] + distance[:, None] * directions[:, :2], valid)


def pixels_from_ground(
    xy: Float[Array, "n 2"],
    camera: CameraModel,
    base_camera: Float64[Array, "4 4"],
    base_height_m: float = 0.0,
) -> Projection:
    """The pixels of places (x, y) on the ground plane, in metres in the base frame; see `ground_from_pixels`."""
    points = np.column_stack([xy, np.full(len(xy), -base_height_m)]).astype(np.float64)
    return camera.project(apply_transform(invert_transform(base_camera), points))
