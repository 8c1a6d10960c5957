"""Recordings of any size for the benchmarks: frames and clouds of a simulated drive, over and over, at fixed rates."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rosbags.rosbag1 import Writer as Ros1Writer
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin
from rosbags.rosbag2 import Writer as Ros2Writer

from navtool.pipeline.geometry.transforms import quaternion_from_rpy, transform_from_xyz_rpy
from navtool.sim.record.messages import MessageFactory
from navtool.sim.record.recorder_config import CameraSetup
from navtool.sim.record.rig import CAMERA, LIDAR, ODOM, RIGS, RobotKind
from navtool.sim.record.stage import make_stage
from navtool.sim.sensors.camera import Camera
from navtool.sim.sensors.lidar import Cloud, Lidar
from navtool.sim.world.scenario import load_scenario

SCENARIO = Path(__file__).parents[1] / "configs" / "scenario" / "demo.yaml"
CAMERA_MODEL = CameraSetup(width=640, height=480, distortion=[]).model()
WHEELS = ("front_left_wheel", "front_right_wheel", "rear_left_wheel", "rear_right_wheel")
CONTAINERS = ("ros1", "mcap", "db3")
START_NS = 1_760_000_000_000_000_000
TICK_NS = 100_000_000
POOL = 40
"""Different frames and clouds; then they come again."""
TYPES = {
    "/tf_static": "tf2_msgs/msg/TFMessage",
    "/camera/image_raw/compressed": "sensor_msgs/msg/CompressedImage",
    "/camera/camera_info": "sensor_msgs/msg/CameraInfo",
    "/velodyne_points": "sensor_msgs/msg/PointCloud2",
    "/odom": "nav_msgs/msg/Odometry",
    "/imu/data": "sensor_msgs/msg/Imu",
    "/joint_states": "sensor_msgs/msg/JointState",
    "/cmd_vel": "geometry_msgs/msg/TwistStamped",
}
SMALL_HZ = {"/odom": 50, "/imu/data": 200, "/joint_states": 50, "/cmd_vel": 10}


def write_bag(folder: Path, container: str, size: float, *, seed: int = 0, name: str = "bench") -> Path:
    """A recording of about so many bytes: 640x480 JPEG and VLP-16 at 10 Hz, odometry, IMU, joints, commands.

    Every cloud has all of its 28,800 returns and every frame the noise of a real sensor, so that a tick weighs about
    0.74 MB, as in recordings of open country; a walled place gives fewer points and therefore more ticks a byte.
    """
    factory = MessageFactory(ros1=container == "ros1")
    frames, clouds = sights()
    written, tick = 0, 0
    with _writer(folder, container, name, factory) as (path, write):
        write("/tf_static", START_NS, factory.mounts(START_NS, RIGS[RobotKind.wheeled].mounts))
        while written < size:
            for topic, stamp_ns, data in _tick(factory, frames[tick % POOL], clouds[tick % POOL], tick, seed):
                write(topic, stamp_ns, data)
                written += len(data)
            tick += 1
    return path


def _tick(
    factory: MessageFactory, frame: NDArray[np.uint8], cloud: Cloud, tick: int, seed: int
) -> Iterator[tuple[str, int, bytes]]:
    """One tenth of a second, in the order of record."""
    start = START_NS + seed * 10**15 + tick * TICK_NS
    messages = [
        ("/camera/image_raw/compressed", start + 5_000_000, factory.jpeg(start, frame, 90)),
        ("/camera/camera_info", start + 5_100_000, factory.camera_info(start, CAMERA_MODEL)),
        ("/velodyne_points", start + 9_000_000, factory.cloud(start + 3_000_000, cloud)),
    ]
    for topic, rate in SMALL_HZ.items():
        for step in range(rate // 10):
            stamp = start + step * (10**9 // rate)
            messages.append((topic, stamp + 1_000_000, _small(factory, topic, stamp, (stamp - START_NS) * 1e-9)))
    return iter(sorted(messages, key=lambda message: message[1]))


def _small(factory: MessageFactory, topic: str, stamp: int, time_s: float) -> bytes:
    wave = np.sin(time_s + np.arange(12.0))
    match topic:
        case "/odom":
            position, turned = np.array([0.8 * time_s, wave[0], 0.0]), np.array([0.0, 0.0, 0.1 * wave[1]])
            velocity = np.array([0.8, 0.0, 0.0, 0.0, 0.0, 0.1 * wave[2]])
            return factory.odometry(stamp, ODOM, position, quaternion_from_rpy(turned), velocity)
        case "/imu/data":
            return factory.imu(stamp, np.array([*wave[:2], 9.81 + wave[2], *wave[3:6]]))
        case "/joint_states":
            return factory.joints(stamp, WHEELS, wave.reshape(3, 4))
        case _:
            return factory.command(stamp, np.array([0.8, 0.1]))


@cache
def sights() -> tuple[list[NDArray[np.uint8]], list[Cloud]]:
    """Frames and clouds along the course of a simulated place; beams without a return are given one."""
    stage = make_stage(load_scenario(SCENARIO), 0)
    world, rig, rng = stage.world, RIGS[RobotKind.wheeled], np.random.default_rng(0)
    camera, lidar = Camera(CAMERA_MODEL), Lidar()
    way = np.linspace(world.start_m, world.goal_m, POOL)
    heading = np.arctan2(*(way[-1] - way[0])[::-1])
    frames, clouds = [], []
    for x, y in way.tolist():
        height = float(world.ground.height_at(np.array([x]), np.array([y]))[0])
        robot = transform_from_xyz_rpy(
            np.array([x, y, height - rig.mount("base_footprint")[2, 3]]), np.array([0.0, 0.0, heading])
        )
        lux = world.config.light.illuminance_lux
        view = camera.picture(stage.shader, _standing(robot @ rig.mount(CAMERA)), lux, rng).rgb
        noisy = view.astype(np.float32) + rng.normal(0.0, 6.0, view.shape).astype(np.float32)
        frames.append(noisy.clip(0, 255).astype(np.uint8))
        firings = _standing(robot @ rig.mount(LIDAR))(lidar.config.column_time_s())
        clouds.append(_full(lidar.measure(stage.scene, firings, rng), np.array(lidar.config.elevation_rad), rng))
    return frames, clouds


def _standing(pose: NDArray[np.float64]) -> Callable[[NDArray[np.float64]], NDArray[np.float64]]:
    """The pose at any times of something that does not move."""
    return lambda time_s: np.repeat(pose[None], len(time_s), axis=0)


def _full(cloud: Cloud, elevation_rad: NDArray[np.float64], rng: np.random.Generator) -> Cloud:
    """The cloud with 28,800 points: those missing are far hits, such as trees beyond the simulated place."""
    missing = 28_800 - len(cloud.xyz)
    azimuth, ring = rng.uniform(-np.pi, np.pi, missing), rng.integers(0, 16, missing).astype(np.uint16)
    distance, elevation = 40 + 20 * np.sin(7 * azimuth) + rng.normal(0, 0.5, missing), elevation_rad[ring]
    level = distance * np.cos(elevation)
    far = np.stack([level * np.cos(azimuth), level * np.sin(azimuth), distance * np.sin(elevation)], axis=1)
    return Cloud(
        np.concatenate([cloud.xyz, far.astype(np.float32)]),
        np.concatenate([cloud.intensity, rng.uniform(1, 60, missing).astype(np.float32)]),
        np.concatenate([cloud.ring, ring]),
        np.concatenate([cloud.time_s, (-azimuth / (20 * np.pi)).astype(np.float32)]),
        np.concatenate([cloud.surface, np.zeros(missing, np.uint8)]),
    )


@contextmanager
def _writer(
    folder: Path, container: str, name: str, factory: MessageFactory
) -> Iterator[tuple[Path, Callable[[str, int, bytes], None]]]:
    store = factory.store
    if container == "ros1":
        path = folder / f"{name}.bag"
        with Ros1Writer(path) as bag:
            ids = {topic: bag.add_connection(topic, kind, typestore=store) for topic, kind in TYPES.items()}
            yield path, lambda topic, stamp, data: bag.write(ids[topic], stamp, data)
        return
    plugin = StoragePlugin.MCAP if container == "mcap" else StoragePlugin.SQLITE3
    writer: Any = Ros2Writer(folder / name, version=9, storage_plugin=plugin)
    if container == "mcap":
        writer.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
    with writer as bag2:
        ids = {topic: bag2.add_connection(topic, kind, typestore=store) for topic, kind in TYPES.items()}
        yield folder / name, lambda topic, stamp, data: bag2.write(ids[topic], stamp, data)
