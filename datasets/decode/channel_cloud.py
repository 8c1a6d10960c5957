"""``sensor_msgs/PointCloud``: the older cloud, whose points have channels beside them."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from jaxtyping import Float32

from navtool.base.errors import DatasetsError
from navtool.datasets.decode.finite_cloud import finite_cloud
from navtool.datasets.decode.header import head_of
from navtool.datasets.decode.messages import PointCloud
from navtool.datasets.decode.point_cloud import INTENSITY_NAMES, RING_NAMES, TIME_NAMES, ring_numbers
from navtool.datasets.decode.point_time import seconds_from_header
from navtool.pipeline.arrays import Array


def decode_channel_cloud(message: Any) -> PointCloud:
    """The points in the order recorded, with the channels that are named like the fields of a PointCloud2.

    Raises:
        DatasetsError: A channel that is used has neither no values nor one a point.
    """
    head = head_of(message)
    points = message.points
    ring = _channel(message, RING_NAMES)
    time = _channel(message, TIME_NAMES)
    return finite_cloud(
        head,
        np.stack([points[axis] for axis in "xyz"]).astype(np.float32, copy=False),
        _channel(message, INTENSITY_NAMES),
        None if ring is None else ring_numbers(ring),
        None if time is None else seconds_from_header(time, head.stamp_ns or 0),
    )


def _channel(message: Any, names: Sequence[str]) -> Float32[Array, " n"] | None:
    """The values of the first of the names that has any; None where none has."""
    by_name = {channel.name.lower(): channel.values for channel in message.channels if len(channel.values)}
    values = next((by_name[name] for name in names if name in by_name), None)
    if values is not None and values.size != message.points.size:
        raise DatasetsError(f"a channel of {values.size} values beside {message.points.size} points")
    return None if values is None else np.asarray(values, np.float32)
