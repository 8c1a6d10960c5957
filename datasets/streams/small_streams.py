"""The small streams of a recording: in the order of time, in the axes of the base frame, their odometry compared."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from navtool.base.note import Note
from navtool.datasets.robot.calibration import Calibration
from navtool.datasets.robot.config import RobotConfig
from navtool.datasets.streams.align import in_base_axes
from navtool.datasets.streams.clock import StreamTime
from navtool.datasets.streams.first_pass import FirstPass
from navtool.datasets.streams.odometry_heading import heading_notes, turned_odometry
from navtool.datasets.streams.odometry_twist import in_own_axes, with_sound_twist
from navtool.datasets.streams.rows import ODOMETRY_COLUMNS
from navtool.datasets.streams.table import is_large
from navtool.datasets.streams.timed_stream import TimedStream


@dataclass(frozen=True, slots=True)
class SmallStreams:
    """Every stream but images and clouds, by its name.

    Attributes:
        streams: In the base frame.
        odometry_notes: What poses and velocities of the odometry say of each other, and what was done.
    """

    streams: dict[str, TimedStream]
    odometry_notes: list[Note] = field(default_factory=list)


def small_streams(
    found: FirstPass, times: Mapping[str, StreamTime], calibration: Calibration, robot: RobotConfig
) -> SmallStreams:
    """Every stream but images and clouds, brought into the base frame.

    Args:
        times: Of every stream, on one clock.
    """
    recorded = {
        name: TimedStream.of(stream, times[name]) for name, stream in found.streams.items() if not is_large(name)
    }
    odometry = recorded.get("odometry")
    if odometry is None or odometry.recorded.columns != ODOMETRY_COLUMNS:
        return SmallStreams(in_base_axes(recorded, calibration))
    own = in_own_axes(odometry, robot.odometry_twist)
    small = in_base_axes(recorded | {"odometry": own.stream}, calibration)
    turned = turned_odometry(small["odometry"], robot.odometry_yaw_rad)
    compared = with_sound_twist(turned, robot.odometry_twist, small)
    small["odometry"] = compared.stream
    return SmallStreams(small, [*own.notes, *compared.notes, *heading_notes(compared.stream)])
