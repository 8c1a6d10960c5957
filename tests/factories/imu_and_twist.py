"""Recordings of an IMU and of commands, whose values count."""

import shutil
from pathlib import Path
from typing import Any

import yaml

from navtool.datasets.recording import RawMessage, open_recording

IMU = "sensor_msgs/msg/Imu"
TWIST = "geometry_msgs/msg/Twist"
EPOCH_NS = 1_700_000_000_000_000_000


def stamped(stamp_ns: int, frame: str = "base") -> dict[str, Any]:
    return {"header": {"stamp": {"sec": stamp_ns // 10**9, "nanosec": stamp_ns % 10**9}, "frame_id": frame}}


def imu_entries(count: int, start_ns: int = EPOCH_NS) -> list[tuple[str, str, int, dict[str, Any]]]:
    """Stamps lie 3 ms before the record times; the angular velocity counts."""
    return [
        (
            "/imu",
            IMU,
            start_ns + k * 10**7,
            {**stamped(start_ns + k * 10**7 - 3 * 10**6), "angular_velocity": {"x": float(k)}},
        )
        for k in range(count)
    ]


def twist_entries(count: int) -> list[tuple[str, str, int, dict[str, Any]]]:
    return [("/cmd_vel", TWIST, EPOCH_NS + 5 * 10**6 + k * 10**8, {"linear": {"x": k / 4}}) for k in range(count)]


def mixed_entries() -> list[tuple[str, str, int, dict[str, Any]]]:
    return sorted([*imu_entries(30), *twist_entries(3)], key=lambda entry: entry[2])


def all_messages(path: Path) -> list[RawMessage]:
    with open_recording(path) as recording:
        return list(recording.messages({topic.name for topic in recording.topics}))


def split_recording(folder: Path, parts: list[Path], metadata: bool) -> Path:
    """A folder of the parts, numbered as rosbag2 does."""
    folder.mkdir()
    names = [f"run_{k}{part.suffix}" for k, part in enumerate(parts)]
    for name, part in zip(names, parts, strict=True):
        shutil.copy(part, folder / name)
    if metadata:
        # Old recorders wrote the folder's name before the file's.
        content = {"rosbag2_bagfile_information": {"relative_file_paths": [f"run/{name}" for name in names]}}
        (folder / "metadata.yaml").write_text(yaml.safe_dump(content))
    return folder
