"""Recordings of a simulated drive, as the robot's own recorder would have written them."""

import shutil
import sqlite3
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int
from rosbags.rosbag1 import Writer as Ros1Writer
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Ros2Writer

from navtool.datasets.recording.raw import RecordingFormat
from navtool.pipeline.arrays import Array
from navtool.sim import lidar
from navtool.sim.errors import SimError
from navtool.sim.messages import MessageFactory
from navtool.sim.proprioception import BATTERY_EVERY, IMU_EVERY, ODOMETRY_EVERY, measure
from navtool.sim.render import Camera, Exposure
from navtool.sim.rig import RigConfig, camera_model, mount
from navtool.sim.robot import STEP_S
from navtool.sim.scene import Scene
from navtool.sim.track import Track

TOPICS = {
    "/tf_static": "tf2_msgs/msg/TFMessage",
    "/camera/front/image_raw/compressed": "sensor_msgs/msg/CompressedImage",
    "/camera/front/camera_info": "sensor_msgs/msg/CameraInfo",
    "/velodyne_points": "sensor_msgs/msg/PointCloud2",
    "/odom": "nav_msgs/msg/Odometry",
    "/imu/data": "sensor_msgs/msg/Imu",
    "/joint_states": "sensor_msgs/msg/JointState",
    "/battery_state": "sensor_msgs/msg/BatteryState",
    "/cmd_vel": "geometry_msgs/msg/TwistStamped",
    "/operator/intervention": "std_msgs/msg/Bool",
    "/ground_truth/event": "std_msgs/msg/String",
}
"""Every topic of a recording, with its type."""
COMMAND_EVERY, INTERVENTION_EVERY = 5, 10
"""Track steps between two commands (20 Hz) and two states of the operator's switch (10 Hz)."""
SUFFIX = {RecordingFormat.mcap: ".mcap", RecordingFormat.ros1: ".bag", RecordingFormat.ros2_db3: ""}
"""How a recording's path ends; a db3 recording is a folder with its metadata.yaml."""


@dataclass(kw_only=True, slots=True)
class TakeConfig:
    """What decides a recording's bytes beside the scene and the track."""

    seed: int = 0
    """Seed of all sensor noise, jitter and drops; at least 0."""
    start_ns: int = 1_760_000_000_000_000_000
    """Stamp of the track's first moment, nanoseconds since 1970."""
    exposure: Exposure = field(default_factory=Exposure)
    """Light and camera exposure."""
    rig: RigConfig = field(default_factory=RigConfig)
    """Camera size, rates and drops."""

    def __post_init__(self) -> None:
        if self.seed < 0 or self.start_ns < 0:
            raise ValueError(f"need seed >= 0 and start_ns >= 0, got {self.seed} and {self.start_ns} ns")


class _Message(NamedTuple):
    record_ns: int
    topic: str
    make: Callable[[], bytes]


def write_recording(
    path: Path, scene: Scene, track: Track, config: TakeConfig, *, storage: RecordingFormat = RecordingFormat.mcap
) -> Path:
    """Write what a robot on a track would have recorded, and return the path.

    Guarantee: the bytes depend on the arguments and on the path's name alone; nothing is left behind on an error.

    Args:
        path: Where to write; ends as ``SUFFIX`` says.
        scene: What the sensors see.
        track: How the robot moves.
        config: Seed, start, light and rig.
        storage: MCAP file, ROS 1 bag or db3 folder.

    Raises:
        SimError: The path exists, ends otherwise than its format asks, or cannot be written.
    """
    if path.suffix != SUFFIX[storage]:
        wanted = f"end it in {SUFFIX[storage]}" if SUFFIX[storage] else "name a folder without a suffix"
        raise SimError(f"a {storage} recording cannot have this name", where=path, cure=wanted)
    if path.exists():
        raise SimError("something is there already", where=path, cure="remove it, or write somewhere else")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix=".partial-", dir=path.parent) as unfinished:
            factory = MessageFactory(ros1=storage is RecordingFormat.ros1)
            written = Path(unfinished) / (path.name if storage is RecordingFormat.ros1 else path.stem)
            with _writer(written, factory, storage) as write:
                for message in _messages(factory, scene, track, config):
                    write(message.topic, message.record_ns, message.make())
            source = written / path.name if storage is RecordingFormat.mcap else written
            shutil.move(source, path)
    except (OSError, sqlite3.Error) as error:
        raise SimError(f"cannot write a recording: {getattr(error, 'strerror', None) or error}", where=path) from error
    return path


@contextmanager
def _writer(
    path: Path, factory: MessageFactory, storage: RecordingFormat
) -> Iterator[Callable[[str, int, bytes], None]]:
    """Open a recording with all topics declared."""
    if storage is RecordingFormat.ros1:
        with Ros1Writer(path) as bag:
            ids = {name: bag.add_connection(name, kind, typestore=factory.store) for name, kind in TOPICS.items()}
            yield lambda topic, stamp, data: bag.write(ids[topic], stamp, data)
        return
    plugin = StoragePlugin.MCAP if storage is RecordingFormat.mcap else StoragePlugin.SQLITE3
    with Ros2Writer(path, version=9, storage_plugin=plugin) as bag2:
        ids = {name: bag2.add_connection(name, kind, typestore=factory.store) for name, kind in TOPICS.items()}
        yield lambda topic, stamp, data: bag2.write(ids[topic], stamp, data)


def _messages(factory: MessageFactory, scene: Scene, track: Track, config: TakeConfig) -> list[_Message]:
    """Return all messages in the order of recording; each is made when it is written."""
    streams = np.random.default_rng(config.seed).spawn(6)
    messages = [
        *_own_motion(factory, track, config, streams[0]),
        *_operator(factory, track, config, streams[1]),
        *_camera(factory, scene, track, config, streams[2:4]),
        *_lidar(factory, scene, track, config, streams[4:6]),
    ]
    return sorted(messages, key=lambda message: message.record_ns)


def _delayed(stamps_ns: Int[Array, "n"], shortest_s: float, rng: np.random.Generator) -> list[int]:
    """Return when the recorder receives what was stamped: after a shortest delay, and sometimes much later."""
    delay = shortest_s * (1 + rng.exponential(0.3, stamps_ns.size))
    received: list[int] = (stamps_ns + (delay * 1e9).astype(np.int64)).tolist()
    return received


def _stamps(track: Track, config: TakeConfig, every: int) -> Int[Array, "n"]:
    return config.start_ns + np.arange(0, track.time_s.size, every, dtype=np.int64) * round(STEP_S * 1e9)


def _shutter_times(
    track: Track, period_s: float, first_s: float, jitter_s: float, drop_share: float, rng: np.random.Generator
) -> Float[Array, " n"]:
    """Return the seconds at which frames are taken that reach the recording."""
    regular = np.arange(first_s, float(track.time_s[-1]), period_s)
    times = np.clip(regular + rng.normal(0.0, jitter_s, regular.size), 0.0, float(track.time_s[-1]))
    return np.asarray(times[rng.random(regular.size) >= drop_share])


def _own_motion(
    factory: MessageFactory, track: Track, config: TakeConfig, rng: np.random.Generator
) -> Iterator[_Message]:
    samples = measure(track, rng)
    streams = (
        ("/imu/data", samples.imu, IMU_EVERY, factory.imu),
        ("/odom", samples.odometry, ODOMETRY_EVERY, factory.odometry),
        ("/joint_states", samples.joints, ODOMETRY_EVERY, factory.joints),
        ("/battery_state", samples.battery, BATTERY_EVERY, factory.battery),
    )
    for topic, values, every, make in streams:
        stamps = _stamps(track, config, every)
        for stamp, received, value in zip(stamps.tolist(), _delayed(stamps, 0.0015, rng), values, strict=True):
            yield _Message(received, topic, partial(make, stamp, value))


def _operator(
    factory: MessageFactory, track: Track, config: TakeConfig, rng: np.random.Generator
) -> Iterator[_Message]:
    """Commands, the operator's switch, the mounts and the true failures."""
    yield _Message(config.start_ns, "/tf_static", partial(factory.static_transforms, config.start_ns))
    stamps = _stamps(track, config, COMMAND_EVERY)
    commands = zip(
        track.command_mps[::COMMAND_EVERY].tolist(), track.command_radps[::COMMAND_EVERY].tolist(), strict=True
    )
    for stamp, received, pair in zip(stamps.tolist(), _delayed(stamps, 0.001, rng), commands, strict=True):
        yield _Message(received, "/cmd_vel", partial(factory.command, stamp, *pair))
    stamps = _stamps(track, config, INTERVENTION_EVERY)
    switch = track.intervention[::INTERVENTION_EVERY].tolist()
    for received, on in zip(_delayed(stamps, 0.002, rng), switch, strict=True):
        yield _Message(received, "/operator/intervention", partial(factory.intervention, active=on))
    for failure in track.failures:
        end_ns = config.start_ns + round(failure.end_s * 1e9)
        yield _Message(end_ns, "/ground_truth/event", partial(factory.event, config.start_ns, failure))


def _camera(
    factory: MessageFactory, scene: Scene, track: Track, config: TakeConfig, rngs: list[np.random.Generator]
) -> Iterator[_Message]:
    timing, noise = rngs
    period = 1 / config.rig.camera_hz
    times = _shutter_times(track, period, timing.uniform(0, period), 0.002, config.rig.drop_share, timing)
    stamps = config.start_ns + (times * 1e9).astype(np.int64)
    model = camera_model(config.rig.width)
    camera = Camera(model)
    poses = track.pose(times) @ mount("camera_front_optical")
    turns = np.interp(times, track.time_s, track.turn_radps)

    def frame(index: int) -> bytes:
        rgb = camera.image(scene, poses[index], config.exposure, float(turns[index]), noise)
        return factory.image(int(stamps[index]), rgb, config.rig.jpeg_quality)

    for index, received in enumerate(_delayed(stamps, 0.018, timing)):
        yield _Message(received, "/camera/front/image_raw/compressed", partial(frame, index))
        yield _Message(received, "/camera/front/camera_info", partial(factory.camera_info, int(stamps[index]), model))


def _lidar(
    factory: MessageFactory, scene: Scene, track: Track, config: TakeConfig, rngs: list[np.random.Generator]
) -> Iterator[_Message]:
    timing, noise = rngs
    first_s = lidar.SWEEP_S * timing.uniform(1, 2)
    times = _shutter_times(track, lidar.SWEEP_S, first_s, 0.0003, config.rig.drop_share, timing)
    stamps = config.start_ns + (times * 1e9).astype(np.int64)
    sensor = mount("velodyne")

    def cloud(index: int) -> bytes:
        poses = track.pose(times[index] + lidar.column_time_s()) @ sensor
        return factory.cloud(int(stamps[index]), lidar.scan(scene, poses, noise))

    for index, received in enumerate(_delayed(stamps, 0.004, timing)):
        yield _Message(received, "/velodyne_points", partial(cloud, index))
