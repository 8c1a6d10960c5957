"""One line a map: when, where, and what it shows."""

from io import StringIO
from pathlib import Path

import numpy as np

from navtool.base.files import write_bytes
from navtool.methods.intensity_map.mapped import MappedSweep
from navtool.pipeline.intensity_map.obstacles import CellClass

_COLUMNS = ("map", "stamp_ns", "x_m", "y_m", "yaw_rad", "goal_rad", "points", *(f"{x.name}_cells" for x in CellClass))


class MapTable:
    """Gathers a line a map and writes them as CSV; a place that is not known is empty."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._text = StringIO()
        self._text.write(",".join(_COLUMNS) + "\n")

    def add(self, mapped: MappedSweep) -> None:
        """Add a map's line."""
        place = mapped.sweep.odom_sensor
        cells = np.bincount(mapped.classes.reshape(-1), minlength=len(CellClass)).tolist()
        at = ["", "", ""] if place is None else [f"{value:.4f}" for value in place.tolist()]
        points = int(mapped.map.layers.points.sum())
        line = [mapped.number, mapped.sweep.stamp_ns, *at, f"{mapped.goal_rad:.4f}", points, *cells]
        self._text.write(",".join(map(str, line)) + "\n")

    def write(self) -> None:
        """Write the file."""
        write_bytes(self._path, self._text.getvalue().encode())
