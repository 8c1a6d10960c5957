"""The small streams as table rows: one decoded message becomes numbers under fixed column names."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from navtool.base.errors import DatasetsError
from navtool.datasets.decode.messages import (
    BatterySample,
    BoolSample,
    FloatSample,
    ImuSample,
    JointSample,
    JoySample,
    OdometrySample,
    PoseSample,
    RobotStateSample,
    TwistSample,
)
from navtool.datasets.robot.config import JoyCommand
from navtool.datasets.streams.table import STREAMS, TWIST_COLUMNS
from navtool.pipeline.arrays import Array

ODOMETRY_COLUMNS = STREAMS["odometry"].columns
IMU_COLUMNS = STREAMS["imu"].columns
BATTERY_COLUMNS = STREAMS["battery"].columns
INTERVENTION_COLUMNS = STREAMS["intervention"].columns
JOINT_KINDS = ("position", "velocity", "effort")


@dataclass(frozen=True, slots=True)
class StreamRows:
    """One message as a row.

    Attributes:
        stamp_ns: Header stamp; None where the type has no header.
        joint_names: Names of a joint state, in the order of the columns; empty for the other types.
        parent: Frame of the poses of an odometry; empty for the other types.
    """

    stamp_ns: int | None
    frame_id: str
    columns: tuple[str, ...]
    values: tuple[float, ...]
    joint_names: tuple[str, ...] = ()
    parent: str = ""


def rows_of(sample: object, stream: str, joy: JoyCommand | None) -> StreamRows:
    """The row of a decoded message.

    Args:
        stream: What the message feeds; an odometry that feeds the command gives its velocity alone.
        joy: How a joystick's axes become a velocity.

    Raises:
        DatasetsError: If the type is not one of the small streams', or a message of several streams lacks this one.
    """
    if isinstance(sample, RobotStateSample):
        sample = _part(sample, stream)
    match sample:
        case TwistSample(linear=linear, angular=angular):
            return StreamRows(sample.stamp_ns, sample.frame_id, TWIST_COLUMNS, _flat(linear, angular))
        case OdometrySample(linear=linear, angular=angular) if stream == "command":
            return StreamRows(sample.stamp_ns, sample.child_frame_id, TWIST_COLUMNS, _flat(linear, angular))
        case JoySample():
            return StreamRows(sample.stamp_ns, sample.frame_id, TWIST_COLUMNS, _velocity(sample, joy))
        case FloatSample():
            return StreamRows(sample.stamp_ns, "", BATTERY_COLUMNS, (sample.value, np.nan, np.nan))
        case PoseSample():
            # No velocity is measured: speeds become differences of poses. Whose pose it is the message does not say.
            values = (*_flat(sample.position, sample.orientation), *(0.0,) * 6)
            return StreamRows(sample.stamp_ns, "", ODOMETRY_COLUMNS, values)
        case OdometrySample():
            values = _flat(sample.position, sample.orientation, sample.linear, sample.angular)
            # The twist is in the child frame: that is the frame in which speeds are meant.
            return StreamRows(sample.stamp_ns, sample.child_frame_id, ODOMETRY_COLUMNS, values, parent=sample.frame_id)
        case ImuSample():
            values = _flat(sample.linear_acceleration, sample.angular_velocity)
            return StreamRows(sample.stamp_ns, sample.frame_id, IMU_COLUMNS, values)
        case BatterySample():
            values = (sample.current_a, sample.voltage_v, sample.percentage)
            return StreamRows(sample.stamp_ns, sample.frame_id, BATTERY_COLUMNS, values)
        case BoolSample():
            return StreamRows(sample.stamp_ns, sample.frame_id, INTERVENTION_COLUMNS, (float(sample.value),))
        case JointSample():
            return _joint_row(sample)
        case _:
            raise DatasetsError(f"{type(sample).__name__} cannot feed a stream", cure="name a topic of a fitting type")


def _part(sample: RobotStateSample, stream: str) -> object:
    part: object = getattr(sample, stream, None)
    if part is None:
        raise DatasetsError(f"the message holds no {stream}", cure=f"name another topic for {stream}")
    return part


def _velocity(sample: JoySample, joy: JoyCommand | None) -> tuple[float, ...]:
    """The velocity that a joystick asks for: vx, vy, vz, wx, wy, wz."""
    if joy is None:
        raise DatasetsError("a joystick's axes have no meaning of their own", cure="describe them in the robot's `joy`")
    wanted = max(joy.forward_axis, joy.turn_axis, joy.left_axis)
    if wanted >= sample.axes.size:
        raise DatasetsError(f"{sample.axes.size} axes, and axis {wanted} is wanted", cure="correct the robot's `joy`")
    if joy.enable_button >= 0 and not (joy.enable_button < sample.buttons.size and sample.buttons[joy.enable_button]):
        return (0.0,) * 6
    axes = np.where(np.abs(sample.axes) < joy.dead_zone, 0.0, sample.axes)
    left = float(axes[joy.left_axis]) * joy.left_mps if joy.left_axis >= 0 else 0.0
    forward, turn = float(axes[joy.forward_axis]) * joy.forward_mps, float(axes[joy.turn_axis]) * joy.turn_radps
    return (forward, left, 0.0, 0.0, 0.0, turn)


@lru_cache(maxsize=16)
def joint_columns(names: tuple[str, ...]) -> tuple[str, ...]:
    """The columns of joints of these names."""
    return tuple(f"{kind}.{name}" for kind in JOINT_KINDS for name in names)


def _joint_row(sample: JointSample) -> StreamRows:
    if not sample.names:
        raise DatasetsError("a joint state without names", cure="leave the stream out: robot.topics.joints=[none]")
    values = _flat(sample.position, sample.velocity, sample.effort)
    return StreamRows(sample.stamp_ns, sample.frame_id, joint_columns(sample.names), values, sample.names)


def _flat(*parts: Array) -> tuple[float, ...]:
    return tuple(float(value) for part in parts for value in part)
