"""Camera images of a scene, by casting one ray a pixel."""

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np
from jaxtyping import Bool, Float, Float32, UInt8

from navtool.pipeline.arrays import Array
from navtool.pipeline.geometry.camera import CameraModel
from navtool.sim.ground import HALF_SIDE_M, TEXEL_M, smooth_noise
from navtool.sim.scene import Scene, Thing

_NEAR_M = 0.02
"""Nothing is closer to the lens than this."""
_LEAF_M = 0.4
"""Leaves are drawn no closer than this: a lens inside a bush sees the leaves around it."""
_TEXELS_PER_M = 200.0
_GROUND_REACH_M = 80.0
_EDGES = np.array([[a, a | axis] for axis in (1, 2, 4) for a in range(8) if not a & axis]).T
"""The twelve edges of a box between its corners, numbered by the bits x, y, z."""
_ZENITH = np.array([96.0, 138.0, 200.0], np.float32)
_HORIZON = np.array([196.0, 206.0, 214.0], np.float32)
_TREELINE = np.array([58.0, 74.0, 56.0], np.float32)
_SUNLIGHT, _AMBIENT = np.float32(0.75), np.float32(0.45)


@dataclass(kw_only=True, slots=True)
class Exposure:
    """How bright the day is and how the camera copes with it."""

    brightness: float = 1.0
    """Factor on all colours; 1 is a bright day, 0.1 deep dusk. In (0, 2]."""
    noise: float = 1.5
    """Standard deviation of the read-out noise in grey levels; at least 0."""
    shutter_s: float = 0.005
    """Exposure time: the image smears over what the robot turns in it. At least 0."""

    def __post_init__(self) -> None:
        if not 0 < self.brightness <= 2 or self.noise < 0 or self.shutter_s < 0:
            raise ValueError(f"need 0 < brightness <= 2, noise >= 0 and shutter_s >= 0, got {self}")


class Camera:
    """A pinhole camera without distortion; integer pixel coordinates are pixel centres, as in OpenCV."""

    def __init__(self, model: CameraModel) -> None:
        self.model = model
        u = (np.arange(model.width, dtype=np.float32) - np.float32(model.cx)) / np.float32(model.fx)
        v = (np.arange(model.height, dtype=np.float32) - np.float32(model.cy)) / np.float32(model.fy)
        rays = np.broadcast_arrays(u[None, :], v[:, None], np.ones((1, 1), np.float32))
        self._rays = np.stack(rays).astype(np.float32)
        bank = np.random.default_rng(7)
        mottle = (smooth_noise(bank, 256, 128) + smooth_noise(bank, 256, 64)).ravel()
        self._mottle = (np.argsort(np.argsort(mottle)) / mottle.size).astype(np.float32)  # uniform in [0, 1)
        self._grain = bank.standard_normal((model.height + 64, model.width + 64, 3), dtype=np.float32)

    def image(
        self,
        scene: Scene,
        world_camera: Float[Array, "4 4"],
        exposure: Exposure,
        yaw_rate_radps: float,
        rng: np.random.Generator,
    ) -> UInt8[Array, "h w 3"]:
        """Return the RGB image from a pose of the optical frame (z forward, x right, y down).

        Args:
            scene: What there is to see.
            world_camera: Pose of the optical frame in the world.
            exposure: Light, noise and shutter.
            yaw_rate_radps: Turn rate during the exposure; smears the image along its rows.
            rng: Source of the read-out noise.
        """
        clean = self.radiance(scene, world_camera)
        smear = abs(yaw_rate_radps) * exposure.shutter_s * self.model.fx
        if smear > 1:
            clean = cv2.filter2D(clean, -1, _box_kernel(smear))
        clean *= np.float32(exposure.brightness)
        row, column = rng.integers(0, 64, 2)
        grain = self._grain[row : row + self.model.height, column : column + self.model.width]
        noisy = clean + np.float32(exposure.noise) * grain + np.float32(0.5)
        return np.asarray(np.clip(noisy, 0, 255).astype(np.uint8))

    def radiance(self, scene: Scene, world_camera: Float[Array, "4 4"]) -> Float32[Array, "h w 3"]:
        """Return the noise-free image, 0-255 and beyond, at a brightness of 1."""
        rotation = world_camera[:3, :3].astype(np.float32)
        origin = world_camera[:3, 3].astype(np.float32).reshape(3, 1, 1)
        rays = (rotation @ self._rays.reshape(3, -1)).reshape(self._rays.shape)
        with np.errstate(divide="ignore", invalid="ignore"):
            picture, depth = _backdrop(scene, origin, rays)
            for thing, window in self._visible(scene, world_camera):
                self._draw(scene, thing, origin, rays[(slice(None), *window)], depth[window], picture[window])
        return cv2.GaussianBlur(picture, (3, 3), 0.6)

    def _visible(self, scene: Scene, world_camera: Float[Array, "4 4"]) -> Iterator[tuple[Thing, tuple[slice, slice]]]:
        """Yield what may be in view with the image window that holds it, nearest first."""
        corners = (scene.corners() - world_camera[:3, 3]) @ world_camera[:3, :3]
        start, end = corners[:, _EDGES[0]], corners[:, _EDGES[1]]
        depths = np.stack([start[..., 2], end[..., 2]])
        share = (_NEAR_M - depths[0]) / (depths[1] - depths[0])
        cut = np.where(
            ((depths > _NEAR_M).sum(axis=0) == 1)[..., None], start + share[..., None] * (end - start), np.nan
        )
        ahead = np.where(corners[..., 2:] > _NEAR_M, corners, np.nan)
        x, y, z = np.moveaxis(np.concatenate([ahead, cut], axis=1), -1, 0)
        size = np.array([[self.model.height], [self.model.width]])
        rows, columns = y / z * self.model.fy + self.model.cy, x / z * self.model.fx + self.model.cx
        pixels = np.stack([rows, columns])
        first = np.clip(np.fmin.reduce(pixels, axis=2), 0, size)
        last = np.clip(np.fmax.reduce(pixels, axis=2) + 2, 0, size)
        seen = (first < last).all(axis=0)
        nearest_first = np.argsort(corners[..., 2].mean(axis=1))
        for index in nearest_first[seen[nearest_first]].tolist():
            (top, left), (bottom, right) = first[:, index].astype(int).tolist(), last[:, index].astype(int).tolist()
            yield scene.things[index], (slice(top, bottom), slice(left, right))

    def _draw(
        self,
        scene: Scene,
        thing: Thing,
        origin: Float32[Array, "3 1 1"],
        rays: Float32[Array, "3 r c"],
        depth: Float32[Array, "r c"],
        picture: Float32[Array, "r c 3"],
    ) -> None:
        """Draw one thing into a window of the picture and of its depth."""
        enter, leave = thing.shape.span(origin, rays)
        nearest = np.float32(_NEAR_M if thing.material.solid else _LEAF_M)
        surface = np.maximum(enter, nearest)
        shown: Bool[Array, "r c"] = (enter < leave) & (leave > nearest) & (surface < depth)
        if thing.material.solid:
            shown &= enter > 0
        if not shown.any():
            return
        reach = np.where(shown, surface, np.float32(1))
        points = origin + reach * rays
        normals = thing.shape.normal(points)
        grain = self._texture(points, normals, reach)
        if not thing.material.solid:
            facing = np.abs(_dot(normals, rays)) / np.sqrt(_dot(rays, rays))
            shown &= (facing > np.float32(1.2) * (np.float32(0.75) - grain)) | (enter < nearest)
        shade = _AMBIENT + _SUNLIGHT * np.maximum(_dot(normals, np.array(scene.sun, np.float32)), np.float32(0))
        shade *= np.float32(1) + np.float32(2 * thing.material.contrast) * (grain - np.float32(0.5))
        colours = _hazy(shade[..., None] * np.array(thing.material.colour, np.float32), reach)
        np.copyto(depth, reach, where=shown)
        np.copyto(picture, colours, where=shown[..., None])

    def _texture(
        self, points: Float32[Array, "3 r c"], normals: Float32[Array, "3 r c"], reach: Float32[Array, "r c"]
    ) -> Float32[Array, "r c"]:
        """Return noise in [0, 1] that is fixed to the world, looked up along the two axes a surface faces least.

        Three octaves; the finest fades with the distance, where a pixel is wider than its features.
        """
        x, y, z = (points * np.float32(_TEXELS_PER_M)).astype(np.int32)
        slope_x, slope_y, slope_z = np.abs(normals)
        top = slope_z > np.float32(0.75)
        row = np.where(top, x, z)
        column = np.where(top | (slope_x > slope_y), y, x)
        fine, middle, coarse = (
            np.take(self._mottle, ((row >> shift & 255) << 8) | (column >> shift & 255)) for shift in (0, 2, 5)
        )
        near = np.minimum(np.float32(0.5), np.float32(0.6) / reach)
        return np.asarray(near * fine + (np.float32(0.65) - near) * middle + np.float32(0.35) * coarse)


def _dot(a: Float32[Array, "3 *n"], b: Float32[Array, "3 *m"]) -> Float32[Array, "..."]:
    return np.asarray(a[0] * b[0] + a[1] * b[1] + a[2] * b[2])


def _backdrop(
    scene: Scene, origin: Float32[Array, "3 1 1"], rays: Float32[Array, "3 h w"]
) -> tuple[Float32[Array, "h w 3"], Float32[Array, "h w"]]:
    """Return sky, treeline and ground, and the ground's depth (infinite for the others)."""
    depth = np.where(rays[2] < 0, -origin[2] / rays[2], np.float32(np.inf))
    picture = np.empty((*depth.shape, 3), np.float32)
    sky = np.flatnonzero(depth.max(axis=1) > _GROUND_REACH_M)
    if sky.size:
        window = slice(int(sky[0]), int(sky[-1]) + 1)
        picture[window] = _sky_colour(scene, rays[:, window])
    low = np.flatnonzero(depth.min(axis=1) < _GROUND_REACH_M)
    if low.size:
        window = slice(int(low[0]), int(low[-1]) + 1)
        colours = _ground_colour(scene, origin, rays[:, window], depth[window])
        np.copyto(picture[window], colours, where=(depth[window] < _GROUND_REACH_M)[..., None])
    return picture, depth


def _sky_colour(scene: Scene, rays: Float32[Array, "3 r w"]) -> Float32[Array, "r w 3"]:
    """Return the sky's gradient, and the far treeline where it stands before it."""
    slope = rays[2] / np.sqrt(rays[0] * rays[0] + rays[1] * rays[1])
    middle = rays[:, rays.shape[1] // 2]
    azimuth = np.arctan2(middle[1], middle[0])
    far_trees = scene.treeline_rad[(azimuth * (360 / np.pi)).astype(np.int64) % 720].astype(np.float32)
    shades = np.linspace(0, 1, 256, dtype=np.float32)[:, None]
    palette = np.concatenate([_HORIZON + shades * (_ZENITH - _HORIZON), _TREELINE[None, :]])
    shade = np.clip(slope * np.float32(1.6 * 255), 0, 255).astype(np.int32)
    shade[slope < far_trees] = 256
    return np.asarray(np.take(palette, shade, axis=0))


def _ground_colour(
    scene: Scene,
    origin: Float32[Array, "3 1 1"],
    rays: Float32[Array, "3 r c"],
    depth: Float32[Array, "r c"],
) -> Float32[Array, "r c 3"]:
    """Return the ground's colour: the coloured map, and the fine texture where it is near enough to resolve."""
    reach = np.minimum(depth, np.float32(_GROUND_REACH_M))
    x, y = origin[0] + reach * rays[0], origin[1] + reach * rays[1]
    scale, shift = np.float32(1 / TEXEL_M), np.float32(HALF_SIDE_M / TEXEL_M - 0.5)
    texels = cv2.remap(
        scene.ground.colour, x * scale + shift, y * scale + shift, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT_101
    )
    fine = np.float32(100)
    detail = cv2.remap(
        scene.ground.detail,
        np.mod(x * fine, np.float32(scene.ground.detail.shape[1])),
        np.mod(y * fine, np.float32(scene.ground.detail.shape[0])),
        cv2.INTER_LINEAR,
        borderMode=cv2.BORDER_WRAP,
    )
    contrast = texels[..., 3] * np.clip(np.float32(3.0) / reach, 0, 1) * np.float32(1 / 255 / 127)
    shade = np.float32(1) + contrast * (detail.astype(np.float32) - np.float32(128))
    return _hazy(texels[..., :3] * shade[..., None], reach)


def _hazy(colours: Float32[Array, "*n 3"], distance_m: Float32[Array, "*n"]) -> Float32[Array, "*n 3"]:
    clear = np.exp(distance_m * np.float32(-1 / 90))[..., None]
    return np.asarray((colours - _HORIZON) * clear + _HORIZON)


def _box_kernel(length_px: float) -> Float32[Array, "1 k"]:
    """Return a horizontal box filter of a length that need not be whole."""
    half = int(np.ceil((length_px - 1) / 2))
    kernel = np.ones((1, 2 * half + 1), np.float32)
    kernel[0, [0, -1]] = (length_px - (2 * half - 1)) / 2
    return np.asarray(kernel / kernel.sum())
