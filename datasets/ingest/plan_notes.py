"""What a user should know of a recording once it was read for the first time."""

from collections.abc import Mapping

import numpy as np
from jaxtyping import Int64

from navtool.base.note import Note
from navtool.datasets.ingest.grid import Grid
from navtool.datasets.ingest.large_stream import LargeStream
from navtool.datasets.recording import Recording
from navtool.datasets.robot.calibration import Calibration
from navtool.datasets.robot.config import RobotConfig
from navtool.datasets.robot.gravity import odd_gravity
from navtool.datasets.streams.config import SyncConfig
from navtool.datasets.streams.first_pass import FirstPass
from navtool.datasets.streams.found_notes import recovered_notes, refused_notes
from navtool.datasets.streams.table import of_kind, row_of, sensor_of
from navtool.datasets.streams.timed_stream import TimedStream
from navtool.pipeline.arrays import Array

_SAME_M, _SAME_DEG = 0.01, 1.0
"""Poses closer than this are one and the same, written down twice."""


def stream_faults(recording: Recording, found: FirstPass) -> list[Note]:
    """Notes on what the recording's files and values are not."""
    return [
        *recovered_notes(recording),
        *found.topics.notes,
        *found.notes,
        *(
            Note(
                "stream.beyond-measure",
                f"{name}: {stream.beyond_measure} values are infinite or beyond 1e15: not measured",
            )
            for name, stream in found.streams.items()
            if stream.beyond_measure
        ),
    ]


def geometry_notes(found: FirstPass, calibration: Calibration, changed: tuple[str, ...]) -> list[Note]:
    """Notes on calibrations and poses that are missing or contradict each other.

    Args:
        changed: Static transforms that were published with different values.
    """
    return [
        *_calibration_notes(found, calibration),
        *calibration.notes,
        *(
            Note("tf.static-changed", f"tf_static: {pair} was published with different values; the last one counts")
            for pair in changed
        ),
    ]


def overrule_notes(robot: RobotConfig, calibration: Calibration) -> list[Note]:
    """Notes on poses and calibrations of the robot file that are not those of the recording: which counts."""
    notes, tree = [], calibration.recorded.tree
    for stream in calibration.poses():
        key, mounting = robot.mounting_of(stream)
        frame = calibration.recorded.frames.get(stream, "")
        pose = tree.pose(robot.base_frame, frame) if frame else None
        if mounting is None or pose is None:
            continue
        away_m, turn = (
            float(np.linalg.norm(mounting.pose()[:3, 3] - pose[:3, 3])),
            mounting.pose()[:3, :3].T @ pose[:3, :3],
        )
        turned_deg = float(np.degrees(np.arccos(np.clip((np.trace(turn) - 1) / 2, -1.0, 1.0))))
        apart = f"tf has a pose {away_m:.2f} m and {turned_deg:.0f} degrees apart"
        if away_m < _SAME_M and turned_deg < _SAME_DEG:
            continue
        if mounting.overrule:
            notes.append(Note("mounting.overrules", f"{key}: counts, as overrule says; {apart}"))
        else:
            cure = f"to use this one, set {key}.overrule: true"
            notes.append(Note("mounting.not-used", f"{key}: is not used, since {apart}; {cure}"))
    for stream in of_kind("camera", calibration.recorded.frames):
        key, fallback = robot.camera_of(stream)
        info = calibration.recorded.info_of(sensor_of(stream))
        if fallback is None or info is None or not info.camera.fx > 0:
            continue
        focal = f"the recording's CameraInfo has fx = {info.camera.fx:.1f} px, the robot file {fallback.fx:.1f} px"
        if fallback.overrule:
            notes.append(Note("calibration.overrules", f"{key}: counts, as overrule says; {focal}"))
        else:
            cure = f"to use this one, set {key}.overrule: true"
            notes.append(Note("calibration.not-used", f"{key}: is not used; {focal}; {cure}"))
    return notes


def gravity_notes(imu: TimedStream | None) -> list[Note]:
    """A note on gravity where it is not what it should be."""
    odd = None if imu is None else odd_gravity(imu.columns("ax_mps2", "ay_mps2", "az_mps2"))
    return [Note("imu.gravity", f"imu: {odd}")] if odd else []


def deskew_notes(small: Mapping[str, TimedStream], *, wanted: bool) -> list[Note]:
    """A note where clouds are to be compensated for a motion that was not recorded."""
    if not wanted or "odometry" in small:
        return []
    what = "lidar: no odometry to compensate the robot's motion with; points stay as measured"
    return [Note("lidar.no-odometry", what)]


def held_notes(large: Mapping[str, LargeStream], grid: Grid, sync: SyncConfig) -> list[Note]:
    """Notes on cameras and LiDARs that have nothing for some of the rows, and the rate that would mend it."""
    notes = []
    for name, stream in large.items():
        lacking, rows = int(np.count_nonzero(~stream.match.valid)), stream.match.valid.size
        if not 0 < lacking < rows or (row_of(name).name == "lidar" and sensor_of(name)):
            continue
        camera = row_of(name).name == "camera"
        what = "picture; the one before it stands there, not valid" if camera else "cloud, and are not valid"
        text = f"{name}: {lacking} of {rows} rows have no {what}"
        rate_hz = _rate_hz(grid.times[name].stamps_ns)
        if rate_hz < 0.9 * _rate_hz(grid.ticks_ns) and rate_hz >= 1.0:
            text += f"; it comes at {rate_hz:.1f} Hz: {_fitting(rate_hz, sync.key_of(name))} gives every row one"
        notes.append(Note("camera.held" if camera else "lidar.lacking", text))
    return notes


def _fitting(rate_hz: float, key: str) -> str:
    """The settings with which a stream of a rate serves every tick."""
    whole = round(rate_hz)
    if abs(rate_hz - whole) < 0.05:
        return f"fps={whole}"
    return f"fps={int(rate_hz)} {key}.tolerance_s={0.5 / rate_hz + 0.01:.2f}"


def _rate_hz(stamps_ns: Int64[Array, " n"]) -> float:
    return 1e9 / float(np.median(np.diff(stamps_ns))) if stamps_ns.size > 1 else 0.0


def _calibration_notes(found: FirstPass, calibration: Calibration) -> list[Note]:
    notes = refused_notes(found)
    for stream in of_kind("camera", found.streams):
        if calibration.camera_of(stream) is None:
            camera = f"camera.{sensor_of(stream)}" if sensor_of(stream) else "camera"
            lost = "its images cannot be projected" if sensor_of(stream) else "trajectory images cannot be made"
            what = f"{camera}: no CameraInfo and none in the robot's configuration; {lost}"
            notes.append(Note("camera.no-calibration", what))
    for sensor, pose in calibration.poses().items():
        stated = sensor != "odometry" or bool(found.streams[sensor].frame_id) if sensor in found.streams else False
        if stated and pose is None:
            frame = found.streams[sensor].frame_id or "(none)"
            unknown = row_of(sensor).name == "camera" or sensor_of(sensor)
            kept = "its pose stays unknown" if unknown else "its axes are taken for the base frame's"
            what = f"{sensor}: no transform from the base frame to {frame} and no mounting configured; {kept}"
            notes.append(Note("sensor.no-pose", what))
    return notes
