"""A recording of a few messages, and what can be asked of any."""

from pathlib import Path
from typing import Any

import numpy as np

from navtool.base.errors import DatasetsError
from navtool.datasets.recording import open_recording

IMU = "sensor_msgs/msg/Imu"
STRING = "std_msgs/msg/String"


def entries() -> list[tuple[str, str, int, dict[str, Any]]]:
    imu = [("/imu", IMU, 10**9 + k * 10**7, {"header": {"stamp": {"sec": 1}, "frame_id": "imu"}}) for k in range(20)]
    cloud = {
        "width": 3,
        "height": 1,
        "fields": [{"name": name, "offset": 4 * k, "datatype": 7, "count": 1} for k, name in enumerate("xyz")],
        "point_step": 12,
        "row_step": 36,
        "data": np.arange(36),
    }
    names = {"name": ["left", "right"], "position": [1.0, 2.0]}
    return [
        *imu,
        ("/points", "sensor_msgs/msg/PointCloud2", 2 * 10**9, cloud),
        ("/joints", "sensor_msgs/msg/JointState", 2 * 10**9 + 1, names),
        ("/note", STRING, 2 * 10**9 + 2, {"data": "hello"}),
    ]


def file_of(path: Path) -> Path:
    """The bag file of what was written, which may lie beside its description and its database's log."""
    beside = ("metadata.yaml", "-wal", "-shm")
    return path if path.is_file() else next(x for x in path.iterdir() if not x.name.endswith(beside))


def read_all(path: Path) -> int:
    """Everything that can be asked of a recording; each message is decoded, whether the one before could be or not."""
    count = 0
    with open_recording(path) as recording:
        for raw in recording.messages({topic.name for topic in recording.topics}):
            count += 1
            for ask in (recording.header_stamp_ns, recording.decode):
                try:
                    ask(raw)
                except DatasetsError as error:
                    assert error.where is not None  # noqa: PT017 - the loop goes on
    return count
