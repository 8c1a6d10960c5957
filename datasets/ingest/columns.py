"""The small columns of an episode: every stream but images and clouds, brought onto the grid."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float64, Int64

from navtool.base.note import Note
from navtool.datasets.store.data_file import Column
from navtool.datasets.store.schema import (
    ACTION_KEY,
    HORIZON_STEPS,
    IMU_KEY,
    POSE_KEY,
    PROPRIOCEPTION_KEY,
    STAMP_KEY,
    STATE_KEY,
    Contents,
)
from navtool.datasets.streams.config import StreamSync, SyncConfig
from navtool.datasets.streams.sync import Brackets, around_ticks
from navtool.datasets.streams.timed_stream import TimedStream, measured, unit_quaternions
from navtool.pipeline.arrays import Array
from navtool.pipeline.geometry.transforms import quaternion_to_rpy, slerp, wrap_angle


@dataclass(slots=True)
class SmallColumns:
    """Columns by key, and what a user should know about them."""

    values: dict[str, Column]
    notes: list[Note]


def small_columns(
    ticks_ns: Int64[Array, " ticks"],
    streams: dict[str, TimedStream],
    contents: Contents,
    config: SyncConfig,
    current_sign: int,
) -> SmallColumns:
    """State, pose, action, IMU, proprioception, labels' defaults and the true time on the grid.

    Values without a valid sample are 0 with ``valid.<stream>`` false; nothing here is NaN or infinite.

    Args:
        streams: The small streams by name; absent ones may be missing.
        current_sign: Sign that a discharging current has in the recording; in the column it is positive.
    """
    ticks = ticks_ns.size
    out = SmallColumns({STAMP_KEY: ticks_ns}, [])
    _state(out, ticks_ns, streams.get("odometry"), config.odometry)
    _action(out, ticks_ns, streams.get("command"), config.command)
    if contents.imu:
        _imu(out, ticks_ns, streams.get("imu"), config.imu)
    if contents.proprioception:
        joints = _joints(out, ticks_ns, streams.get("joints"), contents.joint_names, config.joints)
        current = _battery(out, ticks_ns, streams.get("battery"), config.battery, present=contents.battery)
        out.values[PROPRIOCEPTION_KEY] = np.column_stack([joints, current_sign * current]).astype(np.float32)
    out.values["label.outcome"] = np.ones(ticks, dtype=np.int64)
    out.values["label.known"] = np.zeros((ticks, HORIZON_STEPS), dtype=np.bool_)
    out.values["label.reason"] = np.full(ticks, "", dtype=np.object_)
    out.values["label.confidence"] = np.zeros(ticks, dtype=np.float32)
    return out


def _around(stream: TimedStream, ticks_ns: Int64[Array, " ticks"], sync: StreamSync) -> Brackets:
    return around_ticks(sync.method, stream.time.stamps_ns, ticks_ns, sync.tolerance_s)


def _mark(out: SmallColumns, stream: str, around: Brackets, usable: Bool[Array, " ticks"]) -> None:
    out.values[f"valid.{stream}"] = usable
    out.values[f"sync.error_s.{stream}"] = np.where(usable, around.error_s, 0.0).astype(np.float32)


def _absent(out: SmallColumns, stream: str, ticks: int) -> None:
    out.values[f"valid.{stream}"] = np.zeros(ticks, dtype=np.bool_)
    out.values[f"sync.error_s.{stream}"] = np.zeros(ticks, dtype=np.float32)


def _state(out: SmallColumns, ticks_ns: Int64[Array, " ticks"], stream: TimedStream | None, sync: StreamSync) -> None:
    ticks = ticks_ns.size
    state: Array = np.zeros((ticks, 2))
    pose: Array = np.zeros((ticks, 6))
    if stream is None:
        _absent(out, "state", ticks)
        what = "state: no odometry; observation.state and observation.pose are 0 and not valid"
        out.notes.append(Note("state.no-odometry", what))
    else:
        around = _around(stream, ticks_ns, sync)
        finite = measured(stream)
        usable = around.valid & finite[around.before] & finite[around.after]
        around = Brackets(around.before, around.after, around.weight, around.error_s, usable)
        _mark(out, "state", around, usable)
        values = np.where(finite[:, None], stream.values, 0.0)
        clean = TimedStream(stream.recorded, stream.time, values)
        state = around.linear(clean.columns("vx_mps", "wz_radps"))
        pose = _relative_pose(clean, around)
    out.values[STATE_KEY] = state.astype(np.float32)
    out.values[POSE_KEY] = pose.astype(np.float32)


def _relative_pose(stream: TimedStream, around: Brackets) -> Float64[Array, "ticks 6"]:
    """Pose relative to the first valid tick's position and yaw; roll and pitch stay those of the odometry frame."""
    position = around.linear(stream.columns("x_m", "y_m", "z_m"))
    quaternions = unit_quaternions(stream)
    rpy = quaternion_to_rpy(slerp(quaternions[around.before], quaternions[around.after], around.weight))
    if not around.valid.any():
        return np.zeros((around.valid.size, 6))
    first = int(np.argmax(around.valid))
    offset, yaw = position - position[first], rpy[first, 2]
    pose = np.column_stack(
        [
            offset[:, 0] * np.cos(yaw) + offset[:, 1] * np.sin(yaw),
            -offset[:, 0] * np.sin(yaw) + offset[:, 1] * np.cos(yaw),
            offset[:, 2],
            rpy[:, :2],
            wrap_angle(rpy[:, 2] - yaw),
        ]
    )
    return np.where(around.valid[:, None], pose, 0.0)


def _action(out: SmallColumns, ticks_ns: Int64[Array, " ticks"], stream: TimedStream | None, sync: StreamSync) -> None:
    if stream is None:
        _absent(out, "action", ticks_ns.size)
        what = "action: no commands; the measured speeds stand in, valid.action is false"
        out.notes.append(Note("action.no-commands", what))
        out.values[ACTION_KEY] = out.values[STATE_KEY].copy()
        return
    around = _around(stream, ticks_ns, sync)
    commands = around.linear(stream.columns("vx_mps", "wz_radps"))
    usable = around.valid & np.isfinite(commands).all(axis=1)
    _mark(out, "action", around, usable)
    out.values[ACTION_KEY] = np.where(usable[:, None], commands, out.values[STATE_KEY]).astype(np.float32)


def _imu(out: SmallColumns, ticks_ns: Int64[Array, " ticks"], stream: TimedStream | None, sync: StreamSync) -> None:
    if stream is None:
        _absent(out, "imu", ticks_ns.size)
        out.values[IMU_KEY] = np.zeros((ticks_ns.size, 6), dtype=np.float32)
        return
    around = _around(stream, ticks_ns, sync)
    values = around.linear(stream.values)
    usable = around.valid & np.isfinite(values).all(axis=1)
    _mark(out, "imu", around, usable)
    out.values[IMU_KEY] = np.where(usable[:, None], values, 0.0).astype(np.float32)


def _joints(
    out: SmallColumns,
    ticks_ns: Int64[Array, " ticks"],
    stream: TimedStream | None,
    joint_names: tuple[str, ...],
    sync: StreamSync,
) -> Float64[Array, "ticks joints"]:
    width = 3 * len(joint_names)
    if not joint_names:
        return np.zeros((ticks_ns.size, 0))
    if stream is None:
        _absent(out, "joints", ticks_ns.size)
        return np.zeros((ticks_ns.size, width))
    missing = ~np.asarray(np.isfinite(stream.values).any(axis=0))
    unmeasured = [name for name, absent in zip(stream.recorded.columns, missing, strict=True) if absent]
    if unmeasured:
        what = f"joints: no value was ever recorded for {', '.join(unmeasured)}; they are 0"
        out.notes.append(Note("joints.never-measured", what))
    values = np.zeros((ticks_ns.size, width))
    valid = np.ones(ticks_ns.size, dtype=np.bool_)
    error_s: Array = np.zeros(ticks_ns.size)
    for columns, messages in _publishers(stream, len(joint_names)):
        stamps_ns = stream.time.stamps_ns[messages]
        around = around_ticks(sync.method, stamps_ns, ticks_ns, sync.tolerance_s)
        part = around.linear(stream.values[np.ix_(messages, columns)])
        usable = around.valid & np.isfinite(part[:, ~missing[columns]]).all(axis=1)
        values[:, columns] = np.where(usable[:, None] & np.isfinite(part), part, 0.0)
        error_s = np.where(np.abs(around.error_s) > np.abs(error_s), around.error_s, error_s)
        valid &= usable
    out.values["valid.joints"] = valid
    out.values["sync.error_s.joints"] = np.where(valid, error_s, 0.0).astype(np.float32)
    return values


def _publishers(stream: TimedStream, joints: int) -> list[tuple[Int64[Array, " c"], Int64[Array, " m"]]]:
    """The columns of joints that come together, each with the messages that name them; joints that none names apart."""
    columns: Array = np.arange(stream.values.shape[1])
    present = stream.present
    if present is None:
        return [(columns, np.arange(len(stream.values)))]
    patterns, of_joint = np.unique(present, axis=1, return_inverse=True)
    return [
        (columns[of_joint.reshape(-1)[columns % joints] == number], np.flatnonzero(pattern))
        for number, pattern in enumerate(patterns.T)
        if pattern.any()
    ]


def _battery(
    out: SmallColumns, ticks_ns: Int64[Array, " ticks"], stream: TimedStream | None, sync: StreamSync, *, present: bool
) -> Float64[Array, " ticks"]:
    if stream is None:
        if present:
            _absent(out, "battery", ticks_ns.size)
        return np.zeros(ticks_ns.size)
    around = _around(stream, ticks_ns, sync)
    current = around.linear(stream.columns("current_a"))[:, 0]
    usable = around.valid & np.isfinite(current)
    if around.valid.any() and not usable.any():
        what = "battery: the current was never measured (NaN); it is 0 and valid.battery is false"
        out.notes.append(Note("battery.never-measured", what))
    _mark(out, "battery", around, usable)
    return np.where(usable, current, 0.0)
