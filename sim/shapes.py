"""Convex bodies of the demo world, and where rays enter and leave them."""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Float32

from navtool.pipeline.arrays import Array


class Span(NamedTuple):
    """Ray parameters between which a ray lies inside a body; ``enter > leave`` where it misses."""

    enter: Float32[Array, "..."]
    leave: Float32[Array, "..."]

    def __and__(self, other: "Span") -> "Span":
        """Return the span inside both bodies."""
        return Span(np.maximum(self.enter, other.enter), np.minimum(self.leave, other.leave))


def _slab(origin: Float32[Array, "..."], direction: Float32[Array, "..."], low: float, high: float) -> Span:
    """Return the span between two parallel planes; a ray that runs along them gets infinities of the right sign."""
    inverse = np.float32(1.0) / direction
    a, b = (np.float32(low) - origin) * inverse, (np.float32(high) - origin) * inverse
    return Span(np.minimum(a, b), np.maximum(a, b))


def _quadric(a: Float32[Array, "..."], half_b: Float32[Array, "..."], c: Float32[Array, "..."]) -> Span:
    """Return the span where a t^2 + 2 half_b t + c <= 0, for a > 0."""
    discriminant = half_b * half_b - a * c
    root = np.sqrt(np.maximum(discriminant, np.float32(0.0)))
    hit = discriminant > 0
    far = np.float32(np.inf)
    return Span(np.where(hit, (-half_b - root) / a, far), np.where(hit, (root - half_b) / a, -far))


@dataclass(frozen=True, slots=True)
class Cylinder:
    """A vertical cylinder with caps: a trunk, a pole. Metres, world frame."""

    x: float
    y: float
    radius: float
    height: float
    half_extent: tuple[float, float, float] = field(init=False)
    centre: tuple[float, float, float] = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "half_extent", (self.radius, self.radius, self.height / 2))
        object.__setattr__(self, "centre", (self.x, self.y, self.height / 2))

    def span(self, origin: Float32[Array, "3 ..."], direction: Float32[Array, "3 ..."]) -> Span:
        """Return where rays ``origin + t direction`` are inside; arrays are component first and broadcast."""
        ox, oy = origin[0] - np.float32(self.x), origin[1] - np.float32(self.y)
        dx, dy = direction[0], direction[1]
        side = _quadric(dx * dx + dy * dy, ox * dx + oy * dy, ox * ox + oy * oy - np.float32(self.radius**2))
        return side & _slab(origin[2], direction[2], 0.0, self.height)

    def normal(self, points: Float32[Array, "3 ..."]) -> Float32[Array, "3 ..."]:
        """Return outward unit normals at points on the surface."""
        top = points[2] > np.float32(self.height - 1e-3)
        out = np.where(top, np.float32(0), np.float32(1 / self.radius))
        x, y = (points[0] - np.float32(self.x)) * out, (points[1] - np.float32(self.y)) * out
        return np.stack([x, y, top.astype(np.float32)])

    def clearance(self, xy: Float[Array, "2 ..."]) -> Float[Array, "..."]:
        """Return the horizontal distance in metres from points to the body's outline, negative inside."""
        return np.asarray(np.hypot(xy[0] - self.x, xy[1] - self.y) - self.radius)


@dataclass(frozen=True, slots=True)
class Ellipsoid:
    """An ellipsoid that is round seen from above: a rock, a bush, a crown. Metres, world frame."""

    x: float
    y: float
    z: float
    radius: float
    half_height: float
    half_extent: tuple[float, float, float] = field(init=False)
    centre: tuple[float, float, float] = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "half_extent", (self.radius, self.radius, self.half_height))
        object.__setattr__(self, "centre", (self.x, self.y, self.z))

    def span(self, origin: Float32[Array, "3 ..."], direction: Float32[Array, "3 ..."]) -> Span:
        """Return where rays ``origin + t direction`` are inside; arrays are component first and broadcast."""
        flat, tall = np.float32(1 / self.radius), np.float32(1 / self.half_height)
        ox, oy = (origin[0] - np.float32(self.x)) * flat, (origin[1] - np.float32(self.y)) * flat
        oz = (origin[2] - np.float32(self.z)) * tall
        dx, dy, dz = direction[0] * flat, direction[1] * flat, direction[2] * tall
        c = ox * ox + oy * oy + oz * oz - np.float32(1.0)
        return _quadric(dx * dx + dy * dy + dz * dz, ox * dx + oy * dy + oz * dz, c)

    def normal(self, points: Float32[Array, "3 ..."]) -> Float32[Array, "3 ..."]:
        """Return outward unit normals at points on the surface."""
        flat, tall = np.float32(self.radius**-2), np.float32(self.half_height**-2)
        x, y = (points[0] - np.float32(self.x)) * flat, (points[1] - np.float32(self.y)) * flat
        z = (points[2] - np.float32(self.z)) * tall
        length = np.maximum(np.sqrt(x * x + y * y + z * z), np.float32(1e-9))
        return np.stack([x / length, y / length, z / length])

    def clearance(self, xy: Float[Array, "2 ..."]) -> Float[Array, "..."]:
        """Return the horizontal distance in metres from points to the widest outline, negative inside."""
        return np.asarray(np.hypot(xy[0] - self.x, xy[1] - self.y) - self.radius)


@dataclass(frozen=True, slots=True)
class Box:
    """A box that stands on the ground, turned about the vertical: a wall. Metres and radians, world frame."""

    x: float
    y: float
    half_length: float
    half_width: float
    height: float
    yaw_rad: float
    half_extent: tuple[float, float, float] = field(init=False)
    centre: tuple[float, float, float] = field(init=False)

    def __post_init__(self) -> None:
        cos, sin = abs(np.cos(self.yaw_rad)), abs(np.sin(self.yaw_rad))
        across = float(self.half_length * cos + self.half_width * sin)
        along = float(self.half_length * sin + self.half_width * cos)
        object.__setattr__(self, "half_extent", (across, along, self.height / 2))
        object.__setattr__(self, "centre", (self.x, self.y, self.height / 2))

    def span(self, origin: Float32[Array, "3 ..."], direction: Float32[Array, "3 ..."]) -> Span:
        """Return where rays ``origin + t direction`` are inside; arrays are component first and broadcast."""
        cos, sin = np.float32(np.cos(self.yaw_rad)), np.float32(np.sin(self.yaw_rad))
        ox, oy = origin[0] - np.float32(self.x), origin[1] - np.float32(self.y)
        dx, dy = direction[0], direction[1]
        length = _slab(cos * ox + sin * oy, cos * dx + sin * dy, -self.half_length, self.half_length)
        width = _slab(cos * oy - sin * ox, cos * dy - sin * dx, -self.half_width, self.half_width)
        return length & width & _slab(origin[2], direction[2], 0.0, self.height)

    def normal(self, points: Float32[Array, "3 ..."]) -> Float32[Array, "3 ..."]:
        """Return outward unit normals at points on the surface."""
        cos, sin = np.float32(np.cos(self.yaw_rad)), np.float32(np.sin(self.yaw_rad))
        ox, oy = points[0] - np.float32(self.x), points[1] - np.float32(self.y)
        along, across = cos * ox + sin * oy, cos * oy - sin * ox
        inside = np.stack(
            [self.half_length - np.abs(along), self.half_width - np.abs(across), np.abs(self.height - points[2])]
        )
        face = inside.argmin(axis=0)
        u = np.where(face == 0, np.sign(along), 0.0).astype(np.float32)
        v = np.where(face == 1, np.sign(across), 0.0).astype(np.float32)
        return np.stack([cos * u - sin * v, sin * u + cos * v, (face == 2).astype(np.float32)])

    def clearance(self, xy: Float[Array, "2 ..."]) -> Float[Array, "..."]:
        """Return the horizontal distance in metres from points to the body's outline, negative inside."""
        cos, sin = np.cos(self.yaw_rad), np.sin(self.yaw_rad)
        ox, oy = xy[0] - self.x, xy[1] - self.y
        along = np.abs(cos * ox + sin * oy) - self.half_length
        across = np.abs(cos * oy - sin * ox) - self.half_width
        outside = np.hypot(np.maximum(along, 0.0), np.maximum(across, 0.0))
        return np.asarray(outside + np.minimum(np.maximum(along, across), 0.0))


type Shape = Cylinder | Ellipsoid | Box
