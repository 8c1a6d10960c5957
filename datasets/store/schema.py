"""The columns of a navtool data set: one table of names, types and shapes, and their Arrow form."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field

import pyarrow as pa

from navtool.base.plain import LEFT_OUT_WHILE_EMPTY
from navtool.datasets.streams.table import FRONT, further, sensor_of

SCHEMA_VERSION = 3
"""Raised whenever a column, a file or its meaning changes; readers refuse any other."""
MIGRATED_VERSION = 2
"""The older one that ``navtool migrate`` brings into this form."""

CODEBASE_VERSION = "v3.0"
"""The LeRobot data set format that is written."""

IMAGE_HEIGHT_PX = 240
IMAGE_WIDTH_PX = 320
CLOUD_SIZE = 10_000
HORIZON_STEPS = 10
"""Length of E_t and of ``label.known`` (GrASPE table V, T)."""

IMAGE_KEY = f"observation.images.{FRONT}"
STATE_KEY = "observation.state"
ACTION_KEY = "action"
POSE_KEY = "observation.pose"
IMU_KEY = "observation.imu"
PROPRIOCEPTION_KEY = "observation.proprioception"
COUNT_KEY = "lidar.count"
STAMP_KEY = "stamp_ns"
CAMERA_RELIABILITY_KEYS = tuple(f"reliability.{name}" for name in ("camera", "camera_brightness", "camera_corners"))
CLOUD_RELIABILITY_KEYS = tuple(f"reliability.{name}" for name in ("cloud", "cloud_edge", "cloud_planar"))
DEFAULT_KEYS = ("timestamp", "frame_index", "episode_index", "index", "task_index")
"""LeRobot's own columns: ``timestamp`` is frame_index / fps; the true time is ``stamp_ns``."""


@dataclass(frozen=True, slots=True)
class Feature:
    """One column: LeRobot's dtype (``video`` for the camera), per-row shape, and a name per vector element."""

    dtype: str
    shape: tuple[int, ...]
    names: tuple[str, ...] | None = None

    def to_json(self, fps: int) -> dict[str, object]:
        """The entry of ``info.json``; a video carries what a decoder wants to know beforehand."""
        entry: dict[str, object] = {
            "dtype": self.dtype,
            "shape": list(self.shape),
            "names": None if self.names is None else list(self.names),
        }
        if self.dtype == "video":
            entry["info"] = {
                "video.height": self.shape[0],
                "video.width": self.shape[1],
                "video.channels": 3,
                "video.codec": "h264",
                "video.pix_fmt": "yuv420p",
                "video.fps": fps,
                "is_depth_map": False,
                "has_audio": False,
            }
        return entry


@dataclass(frozen=True, slots=True)
class Contents:
    """What the recordings of a data set have; state, action and labels are always there."""

    camera: bool
    lidar: bool
    imu: bool
    joint_names: tuple[str, ...]
    battery: bool
    cameras: tuple[str, ...] = field(default=(), metadata=LEFT_OUT_WHILE_EMPTY)
    """Further cameras, in the order of their columns."""
    lidars: tuple[str, ...] = field(default=(), metadata=LEFT_OUT_WHILE_EMPTY)
    """Further LiDARs, whose clouds lie whole beside the rows."""

    @property
    def proprioception(self) -> bool:
        """Whether there is a proprioception column."""
        return bool(self.joint_names) or self.battery

    def streams(self) -> tuple[str, ...]:
        """The streams that have a ``valid.*`` and a ``sync.error_s.*`` column, in column order."""
        present = {
            **dict.fromkeys(self.camera_streams, True),
            "lidar": self.lidar,
            "state": True,
            "action": True,
            "imu": self.imu,
            "joints": bool(self.joint_names),
            "battery": self.battery,
        }
        return tuple(name for name, there in present.items() if there)

    @property
    def camera_streams(self) -> tuple[str, ...]:
        """The streams of the cameras: ``camera``, ``camera.rear``."""
        return (*(("camera",) if self.camera else ()), *(further("camera", name) for name in self.cameras))

    @property
    def large(self) -> tuple[str, ...]:
        """The streams of images and clouds that are in the rows."""
        return (*self.camera_streams, *(("lidar",) if self.lidar else ()))

    @property
    def lidar_streams(self) -> tuple[str, ...]:
        """The streams of the further LiDARs."""
        return tuple(further("lidar", name) for name in self.lidars)


def image_key(stream: str) -> str:
    """The column of a camera's stream: ``observation.images.rear`` of ``camera.rear``."""
    return f"observation.images.{sensor_of(stream) or FRONT}"


def camera_reliability_keys(stream: str) -> tuple[str, ...]:
    """The columns of reliability of a camera's stream."""
    sensor = sensor_of(stream)
    return tuple(f"{key}.{sensor}" if sensor else key for key in CAMERA_RELIABILITY_KEYS)


def video_keys(features: Mapping[str, Feature]) -> tuple[str, ...]:
    """The columns that are videos."""
    return tuple(key for key, feature in features.items() if feature.dtype == "video")


def features_of(contents: Contents) -> dict[str, Feature]:
    """The columns of a data set with these contents, in the order in which they are written."""
    features: dict[str, Feature] = {}
    for stream in contents.camera_streams:
        size = (IMAGE_HEIGHT_PX, IMAGE_WIDTH_PX, 3)
        features[image_key(stream)] = Feature("video", size, ("height", "width", "channels"))
    features[STATE_KEY] = Feature("float32", (2,), ("v_mps", "omega_radps"))
    features[ACTION_KEY] = Feature("float32", (2,), ("v_mps", "omega_radps"))
    features[POSE_KEY] = Feature("float32", (6,), ("x_m", "y_m", "z_m", "roll_rad", "pitch_rad", "yaw_rad"))
    if contents.imu:
        names = ("ax_mps2", "ay_mps2", "az_mps2", "wx_radps", "wy_radps", "wz_radps")
        features[IMU_KEY] = Feature("float32", (6,), names)
    if contents.proprioception:
        joints = [f"{kind}.{name}" for kind in ("position", "velocity", "effort") for name in contents.joint_names]
        measured = (*joints, "battery_current_a")
        features[PROPRIOCEPTION_KEY] = Feature("float32", (len(measured),), measured)
    if contents.lidar:
        features[COUNT_KEY] = Feature("int64", (1,))
    reliabilities = (
        *(key for stream in contents.camera_streams for key in camera_reliability_keys(stream)),
        *(CLOUD_RELIABILITY_KEYS if contents.lidar else ()),
    )
    features |= {key: Feature("float32", (1,)) for key in reliabilities}
    features[STAMP_KEY] = Feature("int64", (1,))
    features |= {f"sync.error_s.{stream}": Feature("float32", (1,)) for stream in contents.streams()}
    features |= {f"valid.{stream}": Feature("bool", (1,)) for stream in contents.streams()}
    features["label.outcome"] = Feature("int64", (1,))
    features["label.known"] = Feature("bool", (HORIZON_STEPS,), tuple(f"t+{step}" for step in range(HORIZON_STEPS)))
    features["label.reason"] = Feature("string", (1,))
    features["label.confidence"] = Feature("float32", (1,))
    features["timestamp"] = Feature("float32", (1,))
    features |= {key: Feature("int64", (1,)) for key in DEFAULT_KEYS[1:]}
    return features


def arrow_schema(features: Mapping[str, Feature]) -> pa.Schema:
    """The Arrow schema of a data file, with the metadata by which Hugging Face ``datasets`` knows the columns."""
    columns = [pa.field(key, _arrow_type(feature)) for key, feature in features.items() if feature.dtype != "video"]
    described = {key: _hugging_face(feature) for key, feature in features.items() if feature.dtype != "video"}
    return pa.schema(columns, metadata={"huggingface": json.dumps({"info": {"features": described}})})


def _arrow_type(feature: Feature) -> pa.DataType:
    element: pa.DataType = {
        "float32": pa.float32(),
        "int64": pa.int64(),
        "bool": pa.bool_(),
        "string": pa.string(),
    }[feature.dtype]
    if feature.shape == (1,):
        return element
    return pa.list_(element, feature.shape[0])


def _hugging_face(feature: Feature) -> dict[str, object]:
    value = {"dtype": feature.dtype, "_type": "Value"}
    if feature.shape == (1,):
        return dict(value)
    return {"feature": value, "length": feature.shape[0], "_type": "List"}
