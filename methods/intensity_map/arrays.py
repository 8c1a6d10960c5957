"""A map as NumPy arrays."""

import numpy as np

from navtool.methods.intensity_map.mapped import MappedSweep
from navtool.pipeline.arrays import Array


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
