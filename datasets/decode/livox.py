"""``CustomMsg`` of Livox's drivers: a cloud whose points lie in the message as they are."""

from typing import Any

import numpy as np

from navtool.datasets.decode.finite_cloud import finite_cloud
from navtool.datasets.decode.header import head_of
from navtool.datasets.decode.messages import PointCloud
from navtool.datasets.decode.point_time import seconds_from_base


def decode_livox(message: Any) -> PointCloud:
    """The points in the order recorded; intensity is the reflectivity, 0 to 255, and ring the laser's line.

    Lines of these sensors draw rosettes, they are not level. A beam without a return is recorded as zeros and stays.
    """
    points, head = message.points, head_of(message)
    return finite_cloud(
        head,
        np.stack([points[axis] for axis in "xyz"]).astype(np.float32, copy=False),
        points["reflectivity"].astype(np.float32),
        points["line"].astype(np.uint16),
        seconds_from_base(points["offset_time"], int(message.timebase), head.stamp_ns or 0),
    )
