"""The lamps of a room: panels under its ceiling."""

import numpy as np
from jaxtyping import Float32

from navtool.pipeline.arrays import Array
from navtool.sim.world.scenario import RoomConfig

_SPACING_M = 3.5
_PANEL_M = 0.6
_BELOW_CEILING_M = 0.06
_GRID = 24


class Lamps:
    """What lamps throw onto surfaces of a room, relative to the mean over its empty floor."""

    def __init__(self, room: RoomConfig) -> None:
        along, across = (_row(side) for side in (room.length_m, room.width_m))
        x, y = (values.ravel() for values in np.meshgrid(along, across))
        z = np.full_like(x, room.height_m - _BELOW_CEILING_M)
        self.places_m: Float32[Array, "k 3"] = np.stack([x, y, z], axis=-1)
        """Middle of each panel."""
        grid_x, grid_y = np.meshgrid(
            np.linspace(-0.5, 0.5, _GRID) * room.length_m, np.linspace(-0.5, 0.5, _GRID) * room.width_m
        )
        floor = np.stack([grid_x.ravel(), grid_y.ravel(), np.zeros(_GRID**2)]).astype(np.float32)
        up = np.zeros_like(floor)
        up[2] = 1
        self._scale = np.float32(1)
        self._scale = np.float32(1 / self.unshaded(floor, up).mean())

    def unshaded(self, points: Float32[Array, "3 n"], normals: Float32[Array, "3 n"]) -> Float32[Array, " n"]:
        """The light of all lamps on points that all of them see."""
        total = np.zeros(points.shape[1], np.float32)
        for place in self.places_m:
            total += self.light_of(place, points, normals)
        return total

    def light_of(
        self, place: Float32[Array, "3"], points: Float32[Array, "3 n"], normals: Float32[Array, "3 n"]
    ) -> Float32[Array, " n"]:
        """The light of one panel: by the cosines at both ends, and the square of the distance."""
        x, y, z = place[:, None] - points
        square = x * x + y * y + z * z
        facing = np.maximum(normals[0] * x + normals[1] * y + normals[2] * z, 0)
        return np.asarray(self._scale * facing * np.maximum(z, 0) / np.maximum(square * square, np.float32(1e-3)))

    def within_panels(self, rng: np.random.Generator) -> Float32[Array, "k 3"]:
        """A point on each panel."""
        jitter = np.zeros_like(self.places_m)
        jitter[:, :2] = rng.uniform(-0.5, 0.5, (len(jitter), 2)) * _PANEL_M
        return np.asarray(self.places_m + jitter)


def _row(side_m: float) -> Float32[Array, " k"]:
    """Where the panels are along a side of a room."""
    count = max(1, round(side_m / _SPACING_M))
    return np.asarray(((np.arange(count) + 0.5) / count - 0.5) * side_m, np.float32)
