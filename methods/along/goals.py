"""In which direction the robot is going."""

from typing import ClassVar

import numpy as np
from jaxtyping import Float64

from navtool.datasets.streams.motion import Motion
from navtool.methods.along.config import GoalConfig
from navtool.methods.along.observation import Beside
from navtool.methods.along.streams import Streams
from navtool.methods.along.sweeps import sensor_pose
from navtool.pipeline.arrays import Array

_LEAST_M = 0.5
"""Nearer places give no direction."""
_PIECE = 512


class Goal(Beside[float]):
    """The direction of the goal at a tick, in the axes of the base, in rad; 0, straight on, where it is not known.

    Args:
        config: Which goal.
    """

    reads: ClassVar[tuple[str, ...]] = ("odometry",)

    def __init__(self, config: GoalConfig) -> None:
        self._config = config

    def at(self, streams: Streams, stamp_ns: int) -> float:
        """The direction at a moment, seen from the LiDAR."""
        motion = streams.motion
        place = None if motion is None else sensor_pose(motion, stamp_ns, streams.base_lidar)
        return goal_direction(motion, stamp_ns, place, self._config)


def goal_direction(
    motion: Motion | None, stamp_ns: int, odom_sensor: Float64[Array, "3"] | None, config: GoalConfig
) -> float:
    """The direction of the goal in the frame of the map, in rad; 0, straight on, where it is not known.

    The goal is the first place later on the robot's way that is ``ahead_m`` away from where it is now; where the way
    ends sooner, its last place; within half a metre of that, straight on.

    Args:
        motion: The robot's way.
        stamp_ns: Of the map.
        odom_sensor: Where the sensor is then; None where that is not known.
        config: Which goal.
    """
    if odom_sensor is None:
        return 0.0
    x, y, yaw = odom_sensor.tolist()
    if config.odom_m:
        way = np.array([config.odom_m[0] - x, config.odom_m[1] - y])
    else:
        # the sensor beside the base is moved by the same way
        way = np.zeros(2) if motion is None else _driven(motion, stamp_ns, config.ahead_m)
    if np.hypot(*way) < _LEAST_M:
        return 0.0
    turn = float(np.arctan2(way[1], way[0])) - yaw
    return float(np.arctan2(np.sin(turn), np.cos(turn)))


def _driven(motion: Motion, stamp_ns: int, ahead_m: float) -> Float64[Array, "2"]:
    """The way from where the robot is to where it is ``ahead_m`` away, or to where its way ends."""
    first = min(int(np.searchsorted(motion.stamps_ns, stamp_ns)), len(motion.stamps_ns) - 1)
    here = motion.xyz_m[first, :2]
    for begin in range(first, len(motion.stamps_ns), _PIECE):
        ways = motion.xyz_m[begin : begin + _PIECE, :2] - here
        beyond = np.flatnonzero(np.hypot(ways[:, 0], ways[:, 1]) >= ahead_m)
        if beyond.size:
            return np.asarray(ways[beyond[0]])
    return np.asarray(motion.xyz_m[-1, :2] - here)
