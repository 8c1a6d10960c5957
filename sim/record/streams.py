"""What a robot's recorder receives on a drive, and when: one stream a sensor, made message by message."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from enum import IntEnum
from functools import partial
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Float64, Int64

from navtool.pipeline.arrays import Array
from navtool.pipeline.geometry.transforms import quaternion_from_rpy, rpy_from_transform
from navtool.sim.drive.drive import Drive
from navtool.sim.record.messages import MessageFactory
from navtool.sim.record.recorder_config import CameraSetup, RecorderConfig
from navtool.sim.record.rig import CAMERA, LIDAR, MAP, ODOM, Rig
from navtool.sim.record.stage import Stage
from navtool.sim.record.truth import (
    event_text,
    nanoseconds,
    obstacles_text,
    surfaces_text,
    terrain_changes,
    terrain_text,
)
from navtool.sim.sensors.camera import Camera
from navtool.sim.sensors.lidar import Lidar
from navtool.sim.sensors.lidar_config import LidarConfig

TOPICS = {
    "/tf_static": "tf2_msgs/msg/TFMessage",
    "/tf": "tf2_msgs/msg/TFMessage",
    "/camera/front/image_raw/compressed": "sensor_msgs/msg/CompressedImage",
    "/camera/front/camera_info": "sensor_msgs/msg/CameraInfo",
    "/velodyne_points": "sensor_msgs/msg/PointCloud2",
    "/odom": "nav_msgs/msg/Odometry",
    "/imu/data": "sensor_msgs/msg/Imu",
    "/joint_states": "sensor_msgs/msg/JointState",
    "/battery_state": "sensor_msgs/msg/BatteryState",
    "/cmd_vel": "geometry_msgs/msg/TwistStamped",
    "/operator/intervention": "std_msgs/msg/Bool",
    "/ground_truth/odometry": "nav_msgs/msg/Odometry",
    "/ground_truth/event": "std_msgs/msg/String",
    "/ground_truth/obstacles": "std_msgs/msg/String",
    "/ground_truth/terrain": "std_msgs/msg/String",
}
"""Every topic of a recording, with its type."""
TRUTH_IMAGE_TOPICS = {
    "/ground_truth/surfaces": "std_msgs/msg/String",
    "/ground_truth/segmentation": "sensor_msgs/msg/Image",
    "/ground_truth/depth": "sensor_msgs/msg/Image",
}
"""Those that a recording with the pictures' truth has besides."""
START_NS = 1_760_000_000_000_000_000
"""Stamp of a drive's first moment where nothing else is asked for: nanoseconds since 1970."""
_COMMAND_HZ, _INTERVENTION_HZ, _TRUTH_HZ = 20.0, 10.0, 50.0
_TRUE_VARIANCE = (0.0,) * 6
_MM_LIMIT = 65.0


class _Purpose(IntEnum):
    """What a generator is for. Numbers are never reused: they are part of what a seed means."""

    OWN_MOTION = 101
    OPERATOR = 102
    CAMERA_TIMES = 103
    CAMERA_NOISE = 104
    LIDAR_TIMES = 105
    LIDAR_NOISE = 106


class Entry(NamedTuple):
    """One message as it is recorded."""

    record_ns: int
    topic: str
    data: bytes


class Stream(NamedTuple):
    """Messages that are made when they are written."""

    record_ns: Int64[Array, " n"]
    """When the recorder receives each."""
    make: Callable[[int], Sequence[tuple[str, bytes]]]
    """Topic and bytes of the messages that it receives then."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Take:
    """A drive and all that decides how it is recorded."""

    stage: Stage
    drive: Drive
    rig: Rig
    camera: CameraSetup = field(default_factory=CameraSetup)
    lidar: LidarConfig = field(default_factory=LidarConfig)
    recorder: RecorderConfig = field(default_factory=RecorderConfig)
    truth_images: bool = False
    """Whether to record the surface and the depth of each pixel."""
    seed: int = 0
    """Seed of all sensor noise, jitter and drops."""
    start_ns: int = START_NS
    """Stamp of the drive's first moment."""

    def topics(self) -> dict[str, str]:
        """Every topic that the recording has, with its type."""
        return {**TOPICS, **(TRUTH_IMAGE_TOPICS if self.truth_images else {})}

    def stamps(self, time_s: Float[Array, " n"]) -> Int64[Array, " n"]:
        """Moments of the drive on the recorder's clock."""
        return np.asarray(self.start_ns + np.round(time_s * 1e9).astype(np.int64))

    def rng(self, purpose: _Purpose, index: int = 0) -> np.random.Generator:
        """A generator that depends on the take's seed and on what it is for alone."""
        return np.random.default_rng([self.seed, int(purpose), index])

    def received(
        self, stamps_ns: Int64[Array, " n"], shortest_s: float, rng: np.random.Generator
    ) -> Int64[Array, " n"]:
        """When the recorder receives what was stamped: after a shortest delay, and now and then much later."""
        delay = self.recorder.delay * shortest_s * (1 + rng.exponential(0.3, stamps_ns.size))
        return np.asarray(stamps_ns + (delay * 1e9).astype(np.int64))


def entries(take: Take, factory: MessageFactory) -> Iterator[Entry]:
    """All messages in the order of recording; each is made when it is asked for."""
    streams = [
        _once(take, factory),
        *_own_motion(take, factory),
        *_operator(take, factory),
        *_truth(take, factory),
        _lidar(take, factory),
        _camera(take, factory),
    ]
    record_ns = np.concatenate([stream.record_ns for stream in streams])
    which = np.repeat(np.arange(len(streams)), [stream.record_ns.size for stream in streams])
    index = np.concatenate([np.arange(stream.record_ns.size) for stream in streams])
    for row in np.argsort(record_ns, kind="stable").tolist():
        moment = int(record_ns[row])
        for topic, data in streams[which[row]].make(int(index[row])):
            yield Entry(moment, topic, data)


def _once(take: Take, factory: MessageFactory) -> Stream:
    """What is said once at the start: the mounts, odom in the map, and the place."""
    pose = take.drive.pose(np.zeros(1))[0]
    x, y, z = pose[:3, 3].tolist()
    yaw = float(rpy_from_transform(pose)[2])
    frames = {(MAP, ODOM): (x, y, z, 0.0, 0.0, yaw), **take.rig.mounts}

    def make(_: int) -> list[tuple[str, bytes]]:
        said = [
            ("/tf_static", factory.mounts(take.start_ns, frames)),
            ("/ground_truth/obstacles", factory.text(obstacles_text(take.stage.world))),
        ]
        if take.truth_images:
            said.append(("/ground_truth/surfaces", factory.text(surfaces_text())))
        return said

    return Stream(np.array([take.start_ns], np.int64), make)


def _own_motion(take: Take, factory: MessageFactory) -> Iterator[Stream]:
    """What the robot measures of itself."""
    drive, rng = take.drive, take.rng(_Purpose.OWN_MOTION)
    stamps = take.stamps(drive.odometry.time_s)

    def odometry(index: int) -> list[tuple[str, bytes]]:
        stamp = int(stamps[index])
        x, y, yaw, speed, turn = drive.odometry.values[index].tolist()
        position, turned = np.array([x, y, 0.0]), quaternion_from_rpy(np.array([0.0, 0.0, yaw]))
        velocity = np.array([speed, 0.0, 0.0, 0.0, 0.0, turn])
        return [
            ("/odom", factory.odometry(stamp, ODOM, position, turned, velocity)),
            ("/tf", factory.transform(stamp, position, turned)),
        ]

    yield Stream(take.received(stamps, 0.0015, rng), odometry)
    for topic, measured, make in (
        ("/imu/data", drive.imu, factory.imu),
        ("/joint_states", drive.joints, partial(_joints, factory, drive.joint_names)),
        ("/battery_state", drive.battery, factory.battery),
    ):
        at = take.stamps(measured.time_s)
        yield Stream(take.received(at, 0.0015, rng), partial(_sample, topic, make, at, measured.values))


def _joints(factory: MessageFactory, names: Sequence[str], stamp_ns: int, sample: Array) -> bytes:
    return factory.joints(stamp_ns, names, sample)


def _sample(
    topic: str, make: Callable[[int, Array], bytes], stamps: Int64[Array, " n"], values: Array, index: int
) -> list[tuple[str, bytes]]:
    return [(topic, make(int(stamps[index]), values[index]))]


def _operator(take: Take, factory: MessageFactory) -> Iterator[Stream]:
    """Commands, and the switch that says that the operator frees the robot."""
    drive, rng = take.drive, take.rng(_Purpose.OPERATOR)
    every = _every(drive, _COMMAND_HZ)
    stamps = take.stamps(drive.time_s[::every])
    commands = drive.command[::every]
    yield Stream(take.received(stamps, 0.001, rng), partial(_sample, "/cmd_vel", factory.command, stamps, commands))
    every = _every(drive, _INTERVENTION_HZ)
    switch = drive.intervention[::every].tolist()
    received = take.received(take.stamps(drive.time_s[::every]), 0.002, rng)
    yield Stream(received, lambda index: [("/operator/intervention", factory.flag(active=switch[index]))])


def _truth(take: Take, factory: MessageFactory) -> Iterator[Stream]:
    """Where the robot really is and on what, and its failures as they end."""
    drive, start_ns = take.drive, take.start_ns
    every = _every(drive, _TRUTH_HZ)
    position, turned = drive.position_m[::every], drive.quaternion[::every]
    velocity = np.concatenate([drive.velocity_mps, drive.rates_radps], axis=1)[::every]
    stamps = take.stamps(drive.time_s[::every])

    def odometry(index: int) -> list[tuple[str, bytes]]:
        pose = position[index], turned[index]
        message = factory.odometry(int(stamps[index]), MAP, *pose, velocity[index], _TRUE_VARIANCE)
        return [("/ground_truth/odometry", message)]

    yield Stream(stamps, odometry)
    changes = terrain_changes(drive, take.stage.world.ground)
    yield Stream(
        np.array([start_ns + nanoseconds(change.time_s) for change in changes], np.int64),
        lambda index: [("/ground_truth/terrain", factory.text(terrain_text(changes[index], start_ns)))],
    )
    failures = drive.failures
    yield Stream(
        np.array([start_ns + nanoseconds(failure.end_s) for failure in failures], np.int64),
        lambda index: [("/ground_truth/event", factory.text(event_text(failures[index], start_ns)))],
    )


def _camera(take: Take, factory: MessageFactory) -> Stream:
    """Pictures with their calibration, and their truth where it is asked for."""
    setup, timing, world = take.camera, take.rng(_Purpose.CAMERA_TIMES), take.stage.world
    regular = np.arange(timing.uniform(0, 1 / setup.hz), take.drive.duration_s, 1 / setup.hz)
    jittered = regular + timing.normal(0.0, take.recorder.jitter_s, regular.size)
    times = _kept(np.clip(jittered, 0.0, take.drive.duration_s), take, timing)
    stamps, model, sensor = take.stamps(times), setup.model(), take.rig.mount(CAMERA)
    camera = Camera(model, setup.sensor, take.seed)

    def make(index: int) -> list[tuple[str, bytes]]:
        stamp, moment = int(stamps[index]), float(times[index])
        rng = take.rng(_Purpose.CAMERA_NOISE, index)
        lux = world.config.light.illuminance_lux
        picture = camera.picture(take.stage.shader, lambda s: take.drive.pose(moment + s) @ sensor, lux, rng)
        said = [
            ("/camera/front/image_raw/compressed", factory.jpeg(stamp, picture.rgb, setup.jpeg_quality)),
            ("/camera/front/camera_info", factory.camera_info(stamp, model)),
        ]
        if take.truth_images:
            said.append(("/ground_truth/segmentation", factory.raw_image(stamp, picture.surface)))
            said.append(("/ground_truth/depth", factory.raw_image(stamp, millimetres(picture.depth_m))))
        return said

    return Stream(take.received(stamps, 0.018, timing), make)


def _lidar(take: Take, factory: MessageFactory) -> Stream:
    """Clouds, stamped when their last laser fires."""
    timing, lidar = take.rng(_Purpose.LIDAR_TIMES), Lidar(take.lidar, take.stage.world.config.weather)
    period = 1 / take.lidar.rate_hz
    times = _kept(np.arange(period * timing.uniform(1, 2), take.drive.duration_s, period), take, timing)
    stamps, sensor, columns = take.stamps(times), take.rig.mount(LIDAR), take.lidar.column_time_s()

    def make(index: int) -> list[tuple[str, bytes]]:
        poses = take.drive.pose(times[index] + columns) @ sensor
        cloud = lidar.measure(take.stage.scene, poses, take.rng(_Purpose.LIDAR_NOISE, index))
        return [("/velodyne_points", factory.cloud(int(stamps[index]), cloud))]

    return Stream(take.received(stamps, 0.004, timing), make)


def millimetres(depth_m: Float[Array, "h w"]) -> Array:
    """Depths as depth cameras give them: whole millimetres, 0 where nothing is within 65 m."""
    return np.where(depth_m < _MM_LIMIT, np.round(depth_m * 1000), 0).astype(np.uint16)


def _kept(times_s: Float64[Array, " n"], take: Take, rng: np.random.Generator) -> Float64[Array, " m"]:
    """Those that reach the recording."""
    return np.asarray(times_s[rng.random(times_s.size) >= take.recorder.drop_share])


def _every(drive: Drive, rate_hz: float) -> int:
    """Steps of the truth between two messages."""
    return max(1, round(1 / (rate_hz * float(drive.time_s[1]))))
