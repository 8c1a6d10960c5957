"""A map as NumPy arrays in a compressed file."""

import zipfile
from io import BytesIO
from pathlib import Path

import numpy as np

from navtool.methods.intensity_map.mapped import MappedSweep
from navtool.pipeline.arrays import Array

_EPOCH = (1980, 1, 1, 0, 0, 0)
_LEVEL = 1
"""Of deflate: maps are mostly zeros, of which higher levels make little less in three times the time."""


class ArrayWriter:
    """Writes each map into a file of its own, ``000000.npz`` on, which ``numpy.load`` opens without pickle."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        folder.mkdir(parents=True)

    def add(self, mapped: MappedSweep) -> None:
        """Write a map; the same map gives the same bytes."""
        path = self._folder / f"{mapped.number:06d}.npz"
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=_LEVEL) as file:
            for name, content in map_arrays(mapped).items():
                buffer = BytesIO()
                np.save(buffer, content, allow_pickle=False)
                entry = zipfile.ZipInfo(f"{name}.npy", _EPOCH)
                entry.compress_type = zipfile.ZIP_DEFLATED
                file.writestr(entry, buffer.getvalue(), compresslevel=_LEVEL)


def map_arrays(mapped: MappedSweep) -> dict[str, Array]:
    """What a file holds, by name; docs/intensity_maps.md describes it."""
    odom_sensor = mapped.sweep.odom_sensor
    grid = mapped.config.grid
    return {
        "layers": mapped.values,
        "points": mapped.map.layers.points.astype(np.uint16 if len(mapped.sweep.xyz) < 1 << 16 else np.uint32),
        "classes": mapped.classes,
        "transparent": mapped.map.transparent,
        "plan": mapped.map.plan,
        "odom_sensor": np.full(3, np.nan) if odom_sensor is None else odom_sensor,
        "stamp_ns": np.array(mapped.sweep.stamp_ns, np.int64),
        "goal_rad": np.array(mapped.goal_rad),
        "cell_m": np.array(grid.cell_m),
        "origin_m": np.array([-grid.half_m, -grid.half_m]),
    }
