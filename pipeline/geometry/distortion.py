"""Lens distortion models on the normalised image plane (x / z, y / z)."""

from functools import lru_cache
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float64

from navtool.pipeline.arrays import Array

_NEWTON_STEPS = 25
_CONVERGED = 1e-13
_MOST_COEFFICIENTS = 14


@runtime_checkable
class Distortion(Protocol):
    """A lens model and the field in which it is one to one."""

    max_radius: float
    """The radius on the normalised plane at which the model folds back, or its field of view ends; may be infinite."""
    is_ideal: bool
    """Nothing is distorted."""

    def distort(self, normalised: Float64[Array, "n 2"]) -> Float64[Array, "n 2"]:
        """The distorted position of each point."""

    def undistort(self, distorted: Float64[Array, "n 2"]) -> Float64[Array, "n 2"]:
        """The undistorted position; where there is none, some position that `distort` does not map back."""


class RationalDistortion:
    r"""Radial, tangential and thin prism distortion of a sensor that may be tilted: OpenCV's model of 4 to 14 numbers.

    .. math::
        x' = x \frac{1 + k_1 r^2 + k_2 r^4 + k_3 r^6}{1 + k_4 r^2 + k_5 r^4 + k_6 r^6} + 2 p_1 x y + p_2 (r^2 + 2 x^2)
             + s_1 r^2 + s_2 r^4

    and likewise for y with the roles of p1 and p2 exchanged, and s3 and s4. What a sensor tilted by taux and tauy sees
    is then turned and projected. Reference: OpenCV, "Camera calibration and 3D reconstruction".

    Args:
        coefficients: k1 k2 p1 p2 k3 k4 k5 k6 s1 s2 s3 s4 taux tauy; those left out at the end are 0.

    Note:
        The radius where the model folds back is that of its radial part; the other parts are far smaller.
    """

    def __init__(self, *coefficients: float) -> None:
        padded = (*coefficients, *[0.0] * (_MOST_COEFFICIENTS - len(coefficients)))
        k1, k2, p1, p2, k3, k4, k5, k6, *self._prism = padded[:12]
        self._numerator = np.array([k3, k2, k1, 1.0])
        self._denominator = np.array([k6, k5, k4, 1.0])
        self._tangential = (p1, p2)
        self._tilt = _tilt(*padded[12:]) if any(padded[12:]) else None
        self.is_ideal = not any(padded)
        # With u = r^2 the radial map r N(u) / D(u) turns where (N + 2 u N') D - 2 u N D' is zero; poles are zeros of D.
        n, d = np.poly1d(self._numerator), np.poly1d(self._denominator)
        u = np.poly1d([1.0, 0.0])
        turns = (n + 2 * u * n.deriv()) * d - 2 * u * n * d.deriv()
        self.max_radius = float(np.sqrt(min(_first_positive_root(turns), _first_positive_root(d))))

    def distort(self, normalised: Float64[Array, "n 2"]) -> Float64[Array, "n 2"]:
        """The distorted position of each point."""
        if self.is_ideal:
            return normalised.copy()
        bent = self._bent(normalised)
        return bent if self._tilt is None else _projected(self._tilt, bent)

    def undistort(self, distorted: Float64[Array, "n 2"]) -> Float64[Array, "n 2"]:
        """The undistorted position, by Newton's iteration kept within the field."""
        if self.is_ideal:
            return distorted.copy()
        target = distorted if self._tilt is None else _projected(np.linalg.inv(self._tilt), distorted)
        point = self._within(target)
        for _ in range(_NEWTON_STEPS):
            xx, xy, yx, yy = self._slopes(point)
            error = self._bent(point) - target
            determinant = xx * yy - xy * yx
            determinant = np.where(np.abs(determinant) < 1e-12, 1e-12, determinant)
            step = np.column_stack([yy * error[:, 0] - xy * error[:, 1], xx * error[:, 1] - yx * error[:, 0]])
            before, point = point, self._within(point - step / determinant[:, None])
            if np.abs(point - before).max(initial=0.0) < _CONVERGED:
                break
        return point

    def _bent(self, normalised: Float64[Array, "n 2"]) -> Float64[Array, "n 2"]:
        """What a sensor that is not tilted sees."""
        x, y = normalised[:, 0], normalised[:, 1]
        u = x * x + y * y
        radial = np.polyval(self._numerator, u) / np.polyval(self._denominator, u)
        (p1, p2), (s1, s2, s3, s4) = self._tangential, self._prism
        return np.column_stack(
            [
                x * radial + 2 * p1 * x * y + p2 * (u + 2 * x * x) + u * (s1 + s2 * u),
                y * radial + p1 * (u + 2 * y * y) + 2 * p2 * x * y + u * (s3 + s4 * u),
            ]
        )

    def _slopes(self, point: Float64[Array, "n 2"]) -> tuple[Array, Array, Array, Array]:
        """Derivatives of ``_bent``: of x by x and by y, of y by x and by y."""
        x, y = point[:, 0], point[:, 1]
        u = x * x + y * y
        n, d = np.polyval(self._numerator, u), np.polyval(self._denominator, u)
        radial = n / d
        slope_n, slope_d = np.polyder(self._numerator), np.polyder(self._denominator)
        slope = 2 * (np.polyval(slope_n, u) * d - n * np.polyval(slope_d, u)) / (d * d)
        (p1, p2), (s1, s2, s3, s4) = self._tangential, self._prism
        across, down = 2 * (s1 + 2 * s2 * u), 2 * (s3 + 2 * s4 * u)
        both = slope * x * y + 2 * p1 * x + 2 * p2 * y
        xx = radial + slope * x * x + 2 * p1 * y + 6 * p2 * x + across * x
        yy = radial + slope * y * y + 6 * p1 * y + 2 * p2 * x + down * y
        return xx, both + across * y, both + down * x, yy

    def _within(self, point: Float64[Array, "n 2"]) -> Float64[Array, "n 2"]:
        """The point itself, or the nearest one just inside the field."""
        if not np.isfinite(self.max_radius):
            return point
        radius = np.hypot(point[:, 0], point[:, 1])
        limit = 0.999 * self.max_radius
        kept: Array = point * (limit / np.maximum(radius, limit))[:, None]
        return kept


class EquidistantDistortion:
    r"""The fisheye model: the angle from the axis, not its tangent, grows with the radius in the image.

    .. math::
        r' = \theta (1 + k_1 \theta^2 + k_2 \theta^4 + k_3 \theta^6 + k_4 \theta^8), \quad \theta = \arctan r

    Reference: OpenCV, "Fisheye camera model" (Kannala and Brandt 2006).

    Note:
        Rays at 90 degrees and more from the axis are not modelled: points there count as behind the camera.
    """

    def __init__(self, k1: float, k2: float, k3: float, k4: float) -> None:
        self.is_ideal = False
        self._polynomial = np.array([k4, k3, k2, k1, 1.0])
        self._slope = self._polynomial * (9, 7, 5, 3, 1)
        limit = np.sqrt(_first_positive_root(np.poly1d(self._slope)))
        self._max_angle = float(min(limit, np.pi / 2))
        self.max_radius = float(np.tan(limit)) if limit < np.pi / 2 else float("inf")

    def distort(self, normalised: Float64[Array, "n 2"]) -> Float64[Array, "n 2"]:
        """The distorted position of each point."""
        radius = np.hypot(normalised[:, 0], normalised[:, 1])
        angle = np.arctan(radius)
        distorted = angle * np.polyval(self._polynomial, angle * angle)
        scale = np.where(radius > 0, distorted / np.where(radius > 0, radius, 1.0), 1.0)
        scaled: Array = normalised * scale[:, None]
        return scaled

    def undistort(self, distorted: Float64[Array, "n 2"]) -> Float64[Array, "n 2"]:
        """The undistorted position, by Newton's iteration on the angle kept within the field."""
        target = np.hypot(distorted[:, 0], distorted[:, 1])
        limit = 0.9999 * self._max_angle
        angle = np.minimum(target, limit)
        for _ in range(_NEWTON_STEPS):
            square = angle * angle
            error = angle * np.polyval(self._polynomial, square) - target
            before, angle = angle, np.clip(angle - error / np.maximum(np.polyval(self._slope, square), 1e-6), 0, limit)
            if np.abs(angle - before).max(initial=0.0) < _CONVERGED:
                break
        scale = np.where(target > 0, np.tan(angle) / np.where(target > 0, target, 1.0), 1.0)
        scaled: Array = distorted * scale[:, None]
        return scaled


@lru_cache(maxsize=64)
def lens_distortion(model: str, coefficients: tuple[float, ...]) -> Distortion:
    """The lens model of that name, as sensor_msgs/CameraInfo names it; no coefficients mean an ideal lens of it.

    Raises:
        ValueError: The name is unknown or the number of coefficients is another.
    """
    if model not in LENS_MODELS:
        raise ValueError(f"distortion model is '{model}'; known are {', '.join(LENS_MODELS)}")
    lengths = LENS_MODELS[model]
    if len(coefficients) not in (0, *lengths):
        raise ValueError(
            f"distortion model '{model}' has {len(coefficients)} coefficients; expected {lengths_in_words(model)}"
        )
    if model == "equidistant":
        return EquidistantDistortion(*(coefficients or (0.0,) * 4))
    return RationalDistortion(*coefficients)


LENS_MODELS: dict[str, tuple[int, ...]] = {
    "none": (0,),
    "plumb_bob": tuple(range(4, 15)),
    "rational_polynomial": tuple(range(4, 15)),
    "equidistant": (4,),
}
"""Numbers of coefficients that a lens model may have, by its name; the first two names of OpenCV's are one model."""


def lengths_in_words(model: str) -> str:
    """The numbers of coefficients that a model may have, such as ``4 to 14``."""
    lengths = LENS_MODELS[model]
    return f"{lengths[0]} to {lengths[-1]}" if len(lengths) > 1 else str(lengths[0])


def _tilt(tau_x: float, tau_y: float) -> Float64[Array, "3 3"]:
    """How a tilted sensor sees the normalised plane, in homogeneous terms: OpenCV's ``computeTiltProjectionMatrix``."""
    cos_x, sin_x, cos_y, sin_y = np.cos(tau_x), np.sin(tau_x), np.cos(tau_y), np.sin(tau_y)
    about_x = np.array([[1.0, 0.0, 0.0], [0.0, cos_x, sin_x], [0.0, -sin_x, cos_x]])
    about_y = np.array([[cos_y, 0.0, -sin_y], [0.0, 1.0, 0.0], [sin_y, 0.0, cos_y]])
    turned = about_y @ about_x
    onto_sensor = np.array([[turned[2, 2], 0.0, -turned[0, 2]], [0.0, turned[2, 2], -turned[1, 2]], [0.0, 0.0, 1.0]])
    tilted: Array = onto_sensor @ turned
    return tilted


def _projected(matrix: Float64[Array, "3 3"], points: Float64[Array, "n 2"]) -> Float64[Array, "n 2"]:
    mapped = np.column_stack([points, np.ones(len(points))]) @ matrix.T
    projected: Array = mapped[:, :2] / mapped[:, 2:]
    return projected


def _first_positive_root(polynomial: np.poly1d) -> float:
    """The smallest real root above 0, or infinity."""
    roots = polynomial.roots
    real = roots.real[(np.abs(roots.imag) < 1e-9 * (1 + np.abs(roots.real))) & (roots.real > 1e-12)]
    return float(real.min(initial=np.inf))
