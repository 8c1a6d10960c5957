"""``sensor_msgs/LaserScan``: the sweep of a planar scanner as a cloud."""

import math
from typing import Any

import numpy as np

from navtool.base.errors import DatasetsError
from navtool.datasets.decode.finite_cloud import finite_cloud
from navtool.datasets.decode.header import head_of
from navtool.datasets.decode.messages import PointCloud


def decode_laser_scan(message: Any) -> PointCloud:
    """The returns of a sweep in the order of its beams, in the scanner's frame: x forward, y left, z = 0; one ring.

    A beam without a return is no point, and none that was lost: its range is NaN, infinite or outside of the scanner's
    limits, and it is left out without being counted, like a beam without a return among a LiDAR's packets. What is
    left is finite; ``dropped_nonfinite`` counts ranges beyond all measure. Intensities are there where they are as
    many as the ranges. The header marks the first beam.

    Raises:
        DatasetsError: The angles or the limits are no numbers.
    """
    first, step = float(message.angle_min), float(message.angle_increment)
    nearest, farthest, beam_s = float(message.range_min), float(message.range_max), float(message.time_increment)
    if not (math.isfinite(first) and math.isfinite(step)) or math.isnan(nearest) or math.isnan(farthest):
        raise DatasetsError(
            f"a scan from {first} rad in steps of {step} rad within {nearest} m and {farthest} m: these are no numbers"
        )
    ranges = np.asarray(message.ranges, np.float32)
    beam = np.flatnonzero(np.isfinite(ranges) & (ranges >= nearest) & (ranges <= farthest))
    angle = first + beam * step
    distance = ranges[beam].astype(np.float64)
    columns = np.stack([distance * np.cos(angle), distance * np.sin(angle), np.zeros(beam.size)]).astype(np.float32)
    intensities = np.asarray(message.intensities, np.float32)
    return finite_cloud(
        head_of(message),
        columns,
        intensities[beam] if intensities.size == ranges.size else None,
        np.zeros(beam.size, np.uint16),
        (beam * beam_s).astype(np.float32) if math.isfinite(beam_s) else None,
    )
