"""The pinhole camera with lens distortion, as sensor_msgs/CameraInfo describes it."""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Float64

from navtool.pipeline.arrays import Array
from navtool.pipeline.geometry.distortion import Distortion, lens_distortion

MIN_DEPTH_M = 1e-6


class Projection(NamedTuple):
    """Where points fall in the image."""

    pixels: Float64[Array, "n 2"]
    """(u, v) in pixels, u right and v down; the centre of the top left pixel is (0, 0). NaN where not `in_front`."""
    in_front: Bool[Array, " n"]
    """The point is in front of the camera and within the field of view where its distortion model is one to one."""


class Rays(NamedTuple):
    """The viewing rays of pixels."""

    directions: Float64[Array, "n 3"]
    """(x, y, 1) in the optical frame (z forward, x right, y down). NaN where not `valid`."""
    valid: Bool[Array, " n"]
    """The lens model sees something at this pixel."""


@dataclass(frozen=True)
class CameraModel:
    """Pinhole intrinsics, lens distortion and the image size they belong to.

    Pixel coordinates have the centre of the top left pixel at (0, 0), as OpenCV and ROS do. All arithmetic is float64.

    Raises:
        ValueError: A size or focal length is not positive, a value is not finite, or the distortion model is unknown
            or has another number of coefficients.
    """

    width: int
    """Image width in pixels."""
    height: int
    """Image height in pixels."""
    fx: float
    """Focal length along u in pixels."""
    fy: float
    """Focal length along v in pixels."""
    cx: float
    """Principal point, u in pixels."""
    cy: float
    """Principal point, v in pixels."""
    distortion_model: str = "none"
    """none, plumb_bob or rational_polynomial (the first 4 to 14 of OpenCV's k1 k2 p1 p2 k3 k4 k5 k6 s1 s2 s3 s4 taux
    tauy), or equidistant (k1..k4)."""
    distortion: tuple[float, ...] = ()
    """The model's coefficients in the order of ROS and OpenCV; empty means an ideal lens of that model."""

    def __post_init__(self) -> None:
        if self.width < 1 or self.height < 1:
            raise ValueError(f"camera image size is {self.width}x{self.height} pixels; both must be positive")
        numbers = np.array([self.fx, self.fy, self.cx, self.cy, *self.distortion])
        if not np.isfinite(numbers).all() or self.fx <= 0 or self.fy <= 0:
            focal = f"fx={self.fx}, fy={self.fy}, cx={self.cx}, cy={self.cy}, distortion={self.distortion}"
            raise ValueError(f"camera intrinsics are {focal}: all must be finite and fx, fy positive (uncalibrated?)")
        _ = self._lens

    @cached_property
    def _lens(self) -> Distortion:
        return lens_distortion(self.distortion_model, self.distortion)

    @property
    def max_radius(self) -> float:
        """The largest hypot(x, y) / z that the lens model sees; infinite where it sees everything in front."""
        return self._lens.max_radius

    @property
    def is_ideal(self) -> bool:
        """The lens does not distort: straight lines stay straight."""
        return self._lens.is_ideal

    def matrix(self) -> Float64[Array, "3 3"]:
        """The intrinsic matrix K."""
        return np.array([[self.fx, 0.0, self.cx], [0.0, self.fy, self.cy], [0.0, 0.0, 1.0]])

    def scaled_to(self, width: int, height: int) -> "CameraModel":
        """The model of the same picture resized to `width` x `height`.

        Note:
            Pixel centres are at whole numbers, so the picture's left edge is at -0.5: u' = (u + 0.5) s - 0.5, as
            `cv2.resize` does with linear and area interpolation.
        """
        sx, sy = width / self.width, height / self.height
        return CameraModel(
            width=width,
            height=height,
            fx=self.fx * sx,
            fy=self.fy * sy,
            cx=(self.cx + 0.5) * sx - 0.5,
            cy=(self.cy + 0.5) * sy - 0.5,
            distortion_model=self.distortion_model,
            distortion=self.distortion,
        )

    def project(self, points_optical: Float[Array, "n 3"]) -> Projection:
        """The pixels of points in the optical frame (z forward, x right, y down; metres).

        A point behind the camera, or so far to the side that the distortion polynomial folds back, has no pixel. A
        point in front of the camera may well fall outside the image: compare with `width` and `height`.
        """
        points = points_optical.astype(np.float64)
        in_front = points[:, 2] > MIN_DEPTH_M
        normalised = points[:, :2] / np.where(in_front, points[:, 2], 1.0)[:, None]
        in_front &= np.hypot(normalised[:, 0], normalised[:, 1]) < self.max_radius
        pixels = self.pixels_from_normalised(np.where(in_front[:, None], normalised, 0.0))
        pixels[~in_front] = np.nan
        return Projection(pixels, in_front)

    def rays(self, pixels: Float[Array, "n 2"]) -> Rays:
        """The rays that `project` maps onto the pixels, to 1e-6 pixels; by Newton's iteration on the lens model."""
        wide = pixels.astype(np.float64)
        target = (wide - (self.cx, self.cy)) / (self.fx, self.fy)
        normalised = self._lens.undistort(target)
        directions = np.column_stack([normalised, np.ones(len(wide))])
        # NaN pixels fail the comparison too.
        valid = np.abs(self.pixels_from_normalised(normalised) - wide).max(axis=1, initial=0.0) < 1e-6
        valid &= np.hypot(normalised[:, 0], normalised[:, 1]) < self.max_radius
        directions[~valid] = np.nan
        return Rays(directions, valid)

    def pixels_from_normalised(self, normalised: Float64[Array, "n 2"]) -> Float64[Array, "n 2"]:
        """The pixels of directions (x / z, y / z) within `max_radius`; outside of it they mean nothing."""
        pixels: Array = self._lens.distort(normalised) * (self.fx, self.fy) + (self.cx, self.cy)
        return pixels
