"""A room around the course: walls, a ceiling, and a partition of glass or with a curtained doorway."""

import numpy as np

from navtool.sim.world import structures
from navtool.sim.world.kinds import Spot, long_outline
from navtool.sim.world.mesh import TriangleMesh
from navtool.sim.world.obstacle import Obstacle
from navtool.sim.world.scenario import Partition, RoomConfig

_WALL_M = 0.1
"""Half the thickness of the room's walls."""
_LINTEL_M = structures.CURTAIN_M + 0.02
_GLASS_BESIDE_M = 1.6
"""Width of the glass panel beside a curtained doorway."""


def build_room(config: RoomConfig, rng: np.random.Generator) -> tuple[list[Obstacle], list[TriangleMesh]]:
    """Outlines and triangles of a room about the origin, its length along x."""
    obstacles: list[Obstacle] = []
    meshes = [structures.make_ceiling(config.length_m / 2, config.width_m / 2, config.height_m)]
    length, width = config.length_m / 2, config.width_m / 2
    for x, y, half, yaw in (
        (0.0, width + _WALL_M, length + 2 * _WALL_M, 0.0),
        (0.0, -width - _WALL_M, length + 2 * _WALL_M, 0.0),
        (length + _WALL_M, 0.0, width, np.pi / 2),
        (-length - _WALL_M, 0.0, width, np.pi / 2),
    ):
        _add_wall(x, y, half, float(yaw), config.height_m, obstacles, meshes)
    if config.partition is not Partition.none:
        _add_partition(config, rng, obstacles, meshes)
    return obstacles, meshes


def _add_partition(
    config: RoomConfig, rng: np.random.Generator, obstacles: list[Obstacle], meshes: list[TriangleMesh]
) -> None:
    """Divide the room at x = 0, with one way through at a place of the generator's choice."""
    half, edge = config.width_m / 2, config.passage_m / 2
    room_beside = half - edge - (_GLASS_BESIDE_M if config.partition is Partition.curtain else 0.0) - 0.2
    middle = float(rng.uniform(-1, 1)) * max(room_beside, 0.0)
    low, high = middle - edge, middle + edge
    if config.partition is Partition.glass:
        for start, end in ((-half, low), (high, half)):
            _add_glass(start, end, config.height_m, obstacles, meshes)
        return
    side = 1 if rng.random() < 0.5 else -1
    glass = sorted((middle + side * edge, middle + side * (edge + _GLASS_BESIDE_M)))
    _add_glass(glass[0], glass[1], config.height_m, obstacles, meshes)
    for start, end in ((-half, min(low, glass[0])), (max(high, glass[1]), half)):
        if end - start > 0.02:
            _add_wall(0.0, (start + end) / 2, (end - start) / 2, np.pi / 2, config.height_m, obstacles, meshes)
    lintel = structures.make_wall(edge, 0.06, config.height_m - _LINTEL_M - 0.15, np.pi / 2, "plaster")
    meshes.append(lintel.moved(0.0, middle, _LINTEL_M + 0.15))
    meshes.append(structures.make_curtain(edge, np.pi / 2, rng).moved(0.0, middle, 0.0))
    spot = Spot(0.0, middle, np.pi / 2, 0.0, 0.0)
    obstacles.append(long_outline(spot, "curtain", "bead", edge, 0.04, structures.CURTAIN_M))


def _add_wall(
    x: float, y: float, half: float, yaw: float, height: float, obstacles: list[Obstacle], meshes: list[TriangleMesh]
) -> None:
    obstacles.append(long_outline(Spot(x, y, yaw, 0.0, 0.0), "wall", "plaster", half, _WALL_M, height))
    meshes.append(structures.make_wall(half, _WALL_M, height, yaw, "plaster").moved(x, y, 0.0))


def _add_glass(start: float, end: float, height: float, obstacles: list[Obstacle], meshes: list[TriangleMesh]) -> None:
    if end - start < 0.05:
        return
    spot = Spot(0.0, (start + end) / 2, np.pi / 2, 0.0, 0.0)
    half = (end - start) / 2
    obstacles.append(long_outline(spot, "glass", "glass", half, structures.GLASS_THICKNESS_M / 2, height))
    meshes.append(structures.make_pane(half, height, spot.yaw_rad).moved(0.0, spot.y_m, 0.0))
