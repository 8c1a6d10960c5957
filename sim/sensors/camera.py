"""Pictures of a camera that moves through a world, with their truth."""

from collections.abc import Callable
from typing import NamedTuple

import cv2
import numpy as np
from jaxtyping import Bool, Float, Float32, Int32, UInt8

from navtool.pipeline.arrays import Array
from navtool.pipeline.geometry.camera import CameraModel
from navtool.sim.sensors.camera_config import CameraConfig
from navtool.sim.sensors.exposure import Exposure, choose_exposure, develop
from navtool.sim.sensors.motion_blur import blurred
from navtool.sim.sensors.shader import SKY, Shader
from navtool.sim.world.randomness import Purpose, generator

PoseAt = Callable[[Float[Array, " k"]], Float[Array, "k 4 4"]]
"""Poses of the optical frame (z forward, x right, y down) in the world at seconds from the middle of the exposure."""

_NEAR_M = 7.0
"""Leaves and blades nearer than this show as single ones."""
_DIRT_COLOUR = np.array([0.5, 0.42, 0.33], np.float32)
"""Colour of dried mud on the lens, relative to the picture's mean."""

_OFFSETS_PX = np.array(
    [
        [0.33, -0.25],
        [-0.33, 0.25],
        [0.25, 0.33],
        [-0.25, -0.33],
        [0.4, 0.05],
        [-0.4, -0.05],
        [0.05, -0.4],
        [-0.05, 0.4],
    ],
    np.float32,
)
_OFFSETS_PX = np.pad(_OFFSETS_PX, ((0, 0), (0, 1)))
"""Where further rays go through a pixel."""


class Picture(NamedTuple):
    """One picture, and what is really there at the middle of its exposure."""

    rgb: UInt8[Array, "h w 3"]
    surface: UInt8[Array, "h w"]
    """Number of the surface in each pixel; 255 for the sky, and where the lens sees nothing."""
    depth_m: Float32[Array, "h w"]
    """Along the optical axis; infinite for the sky."""
    exposure: Exposure


class Camera:
    """A camera with its lens; what does not change from picture to picture is computed once."""

    def __init__(self, model: CameraModel, config: CameraConfig | None = None, seed: int = 0) -> None:
        """Take a camera into the hand.

        Args:
            model: Size, calibration and lens.
            config: Shutter, sensor and dirt.
            seed: Decides where the dirt is.
        """
        self.model, self.config = model, config if config is not None else CameraConfig()
        u, v = np.meshgrid(np.arange(model.width), np.arange(model.height))
        found = model.rays(np.column_stack([u.ravel(), v.ravel()]).astype(np.float64))
        self._rays: Array = found.directions.reshape(model.height, model.width, 3)
        self._seen: Array = found.valid
        usable = np.where(found.valid[:, None], found.directions, [0.0, 0.0, 1.0])
        self._components: Array = np.ascontiguousarray(usable.T, np.float32)
        self._offsets = _OFFSETS_PX.T[:, :, None] / np.array([model.fx, model.fy, 1.0], np.float32)[:, None, None]
        cosine = 1 / np.linalg.norm(usable, axis=1)
        falloff = np.where(found.valid, 1 - self.config.vignetting * (1 - cosine**4), 0.0)
        flat = np.repeat(falloff.astype(np.float32), 3)
        self._falloff: Array = flat.reshape(model.height, model.width, 3)
        self.dirt: Float32[Array, "h w 1"] = _dirt(model, self.config.dirt_share, generator("dirt", seed, Purpose.DIRT))
        """How much of each pixel's light dirt on the lens takes, 0-1."""

    def picture(self, shader: Shader, pose_at: PoseAt, illuminance_lux: float, rng: np.random.Generator) -> Picture:
        """Take a picture.

        Guarantee: equal arguments give equal pictures.

        Args:
            shader: The world as light shows it.
            pose_at: How the camera moves about the middle of the exposure.
            illuminance_lux: What falls on open ground.
            rng: Source of the noise.
        """
        pose = pose_at(np.zeros(1))[0]
        light, surface, depth = self._look(shader, pose)
        light *= self._falloff
        exposure = choose_exposure(light, illuminance_lux, self.config)
        moments = (np.arange(self.config.blur_poses) + 0.5) / self.config.blur_poses - 0.5
        poses = pose_at(moments * exposure.shutter_s)
        light = blurred(light, depth, self._rays, self.model, pose, poses)
        if self.config.blur_px > 0:
            light = cv2.GaussianBlur(light, (0, 0), self.config.blur_px)
        if self.config.dirt_share > 0:
            mean = np.minimum(light, 1).mean(axis=(0, 1)) * _DIRT_COLOUR
            light = light + self.dirt * (mean - light)
        rgb = develop(np.ascontiguousarray(light, np.float32), illuminance_lux, exposure, self.config, rng)
        return Picture(rgb, surface, depth, exposure)

    def _look(self, shader: Shader, pose: Float[Array, "4 4"]) -> tuple[Array, Array, Array]:
        """The light that each pixel would see if nothing moved, and the surface and depth that are there."""
        height, width = self.model.height, self.model.width
        eye, turn = pose[:3, 3].astype(np.float32), pose[:3, :3].astype(np.float32)
        seen = shader.see(eye, _turned(turn, self._components), 1 / self.model.fx)
        surface = np.where(self._seen, seen.surface, np.uint8(SKY)).reshape(height, width)
        depth = np.where(self._seen, seen.depth, np.float32(np.inf)).reshape(height, width)
        light, count = seen.radiance, self.config.edge_rays
        mixed = np.flatnonzero(_mixed(surface, depth, seen.triangle.reshape(height, width), shader.small))
        if count and mixed.size:
            rays = self._components[:, None, mixed] + self._offsets[:, :count]
            further = shader.see(eye, _turned(turn, rays.reshape(3, -1)), 1 / self.model.fx).radiance
            for channel, more in zip(light, further.reshape(3, count, -1).sum(axis=1), strict=True):
                channel[mixed] = (channel[mixed] + more) * np.float32(1 / (1 + count))
        return np.ascontiguousarray(light.T).reshape(height, width, 3), surface, depth


def _turned(turn: Float32[Array, "3 3"], rays: Float32[Array, "3 n"]) -> Float32[Array, "3 n"]:
    """Rays in the world."""
    x, y, z = rays
    return np.stack([row[0] * x + row[1] * y + row[2] * z for row in turn])


def _mixed(
    surface: UInt8[Array, "h w"],
    depth: Float32[Array, "h w"],
    triangle: Int32[Array, "h w"],
    small: Bool[Array, " surfaces"],
) -> Bool[Array, "h w"]:
    """Pixels with or next to leaves and blades so near that each of them shows, unless one of them fills the pixel."""
    tiny = np.append(small, np.zeros(256 - len(small), bool))[surface]
    near = cv2.dilate((tiny & (depth < _NEAR_M)).astype(np.uint8), np.ones((3, 3), np.uint8))
    edge = np.zeros(triangle.shape, bool)
    across, down = triangle[:, 1:] != triangle[:, :-1], triangle[1:] != triangle[:-1]
    edge[:, 1:] |= across
    edge[:, :-1] |= across
    edge[1:] |= down
    edge[:-1] |= down
    return np.asarray(edge & near.astype(bool))


def _dirt(model: CameraModel, share: float, rng: np.random.Generator) -> Float32[Array, "h w 1"]:
    """Soft specks and smears, out of focus."""
    if share == 0:
        return np.zeros((model.height, model.width, 1), np.float32)
    coarse = np.sum([cv2.resize(rng.standard_normal((k * 3, k * 4)), (160, 120)) / k**0.5 for k in (2, 4, 9)], axis=0)
    blotches = cv2.resize(coarse, (model.width, model.height), interpolation=cv2.INTER_CUBIC)
    edge = np.quantile(blotches, 1 - share) if share < 1 else float(blotches.min()) - 1.0
    cover = np.clip((blotches - edge) * 4 + 0.5, 0, 1) * 0.94
    soft = cv2.GaussianBlur(cover.astype(np.float32), (0, 0), 0.012 * model.width)
    return np.asarray(soft[..., None], np.float32)
