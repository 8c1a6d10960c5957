"""The small streams of a recording: in the order of time, in the axes of the base frame."""

from collections.abc import Mapping

from navtool.datasets.robot.calibration import Calibration
from navtool.datasets.robot.config import RobotConfig
from navtool.datasets.streams.align import in_base_axes
from navtool.datasets.streams.clock import StreamTime
from navtool.datasets.streams.first_pass import FirstPass
from navtool.datasets.streams.odometry_heading import turned_odometry
from navtool.datasets.streams.table import is_large
from navtool.datasets.streams.timed_stream import TimedStream


def small_streams(
    found: FirstPass, times: Mapping[str, StreamTime], calibration: Calibration, robot: RobotConfig
) -> dict[str, TimedStream]:
    """Every stream but images and clouds, by its name.

    Args:
        times: Of every stream, on one clock.
    """
    recorded = {
        name: TimedStream.of(stream, times[name]) for name, stream in found.streams.items() if not is_large(name)
    }
    small = in_base_axes(recorded, calibration)
    if "odometry" in small:
        small["odometry"] = turned_odometry(small["odometry"], robot.odometry_yaw_rad)
    return small
