"""Sensors mounted turned, upside down or away from the base frame measure what one at its origin would."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from noted import noted

from navtool.datasets.check import Severity, check_dataset
from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.ingest.ingest import ingest
from navtool.datasets.robot.config import RobotConfig
from navtool.datasets.robot.gravity import odd_gravity
from navtool.datasets.robot.odometry_twist import OdometryTwist
from navtool.datasets.robot.sensor_config import Mounting
from navtool.datasets.store.reader import NavDataset
from navtool.pipeline.geometry.transforms import (
    quaternion_from_rpy,
    quaternion_from_transform,
    transform_from_xyz_quaternion,
    transform_from_xyz_rpy,
)

Write = Callable[..., Path]
Drive = Callable[..., list[Any]]
MOUNTS = {
    "upside down": ((0.1, 0.0, 0.3), (np.pi, 0.0, 0.0)),
    "on its side": ((0.0, 0.2, 0.1), (np.pi / 2, 0.0, 0.0)),
    "anyhow": ((0.3, -0.1, 0.5), (0.4, -0.8, 2.0)),
}


def _vector(values: Any) -> dict[str, float]:
    return dict(zip("xyz", map(float, values), strict=True))


def _quaternion(values: Any) -> dict[str, float]:
    return dict(zip("xyzw", map(float, values), strict=True))


def _in_sensor(entry: Any, mount: Any) -> Any:
    """What an IMU in this mount would have measured, and the odometry of a frame that sits in it."""
    topic, kind, record_ns, fields = entry
    turn = mount[:3, :3].T
    if topic == "/imu/data":
        acceleration = [fields["linear_acceleration"][axis] for axis in "xyz"]
        turned = _vector(turn @ acceleration)
        return topic, kind, record_ns, fields | {"linear_acceleration": turned, "angular_velocity": _vector(turn[:, 2])}
    if topic == "/odom":
        pose = fields["pose"]["pose"]
        position = [pose["position"][axis] for axis in "xyz"]
        attitude = [pose["orientation"][axis] for axis in "xyzw"]
        child = transform_from_xyz_quaternion(np.array(position), np.array(attitude)) @ mount
        moved = {"position": _vector(child[:3, 3]), "orientation": _quaternion(quaternion_from_transform(child))}
        linear = [fields["twist"]["twist"]["linear"][axis] for axis in "xyz"]
        omega = np.array([0.0, 0.0, 0.5])
        twist = {
            "linear": _vector(turn @ (linear + np.cross(omega, mount[:3, 3]))),
            "angular": _vector(turn @ omega),
        }
        tracked = {"child_frame_id": "tracker", "pose": {"pose": moved}, "twist": {"twist": twist}}
        return topic, kind, record_ns, fields | tracked
    return entry


@pytest.mark.parametrize("name", MOUNTS)
def test_imu_and_odometry_are_turned_into_the_base_frame(
    name: str, write_recording: Write, drive_entries: Drive, tmp_path: Path
) -> None:
    xyz, rpy = MOUNTS[name]
    mount = transform_from_xyz_rpy(np.array(xyz), np.array(rpy))
    straight = [entry for entry in drive_entries(4.0) if entry[0] != "/tf_static"]
    mounted = Mounting(xyz_m=list(xyz), rpy_rad=list(rpy))
    reports, as_recorded = {}, OdometryTwist.as_recorded  # its poses do not turn
    for case, entries, robot in (
        ("as it is", [_in_sensor(entry, np.eye(4)) for entry in straight], RobotConfig(odometry_twist=as_recorded)),
        (
            "mounted",
            [_in_sensor(entry, mount) for entry in straight],
            RobotConfig(mounting={"imu": mounted, "odometry": mounted}, odometry_twist=as_recorded),
        ),
    ):
        path = write_recording("mcap", entries, name=f"bag {case}")
        reports[case] = ingest([path], tmp_path / case, robot, IngestConfig())
    plain, turned = (NavDataset(tmp_path / case) for case in ("as it is", "mounted"))
    for key in ("observation.imu", "observation.state", "observation.pose"):
        np.testing.assert_allclose(turned.column(key), plain.column(key), atol=2e-5, err_msg=key)
    assert plain.column("observation.state")[5].tolist() == pytest.approx([1.0, 0.5])
    for stream in ("imu", "odometry"):
        one, other = plain.stream(0, stream), turned.stream(0, stream)
        assert one is not None
        assert other is not None
        for column in ("wz_radps", "wx_radps"):
            np.testing.assert_allclose(other[column], one[column], atol=1e-9)
    assert not any(noted(report.episodes[0].notes, "imu.gravity") for report in reports.values())


def test_a_turned_imu_without_a_known_pose_is_told(
    write_recording: Write, drive_entries: Drive, tmp_path: Path
) -> None:
    mount = transform_from_xyz_rpy(np.zeros(3), np.array([np.pi / 2, 0.0, 0.0]))
    entries = [_in_sensor(entry, mount) if entry[0] == "/imu/data" else entry for entry in drive_entries(4.0)]
    report = ingest(
        [write_recording("mcap", [entry for entry in entries if entry[0] != "/tf_static"])],
        tmp_path / "out",
        RobotConfig(),
        IngestConfig(),
    )
    assert "imu: gravity is along +y, not +z" in noted(report.episodes[0].notes, "imu.gravity")[0]
    found = [x for x in check_dataset(tmp_path / "out").findings if "gravity is along +y" in x.message]
    assert [(x.severity, x.check) for x in found] == [(Severity.WARN, "native")]


@pytest.mark.parametrize(
    ("scale", "rpy", "told"),
    [
        (9.81, (0.0, 0.0, 1.0), None),
        (9.81, (0.3, -0.3, 0.0), None),
        (9.81, (np.pi, 0.0, 0.0), "along -z"),
        (9.81, (0.0, np.pi / 2, 0.0), "along -x"),
        (1.0, (0.0, 0.0, 0.0), "in g"),
        (0.05, (0.0, 0.0, 0.0), "taken out"),
    ],
)
def test_gravity_says_how_a_sensor_is_mounted(scale: float, rpy: tuple[float, ...], told: str | None) -> None:
    turn = transform_from_xyz_quaternion(np.zeros(3), quaternion_from_rpy(np.array(rpy)))[:3, :3]
    noise = np.random.default_rng(0).normal(0, 0.02 * scale, (500, 3))
    found = odd_gravity((np.array([0.0, 0.0, scale]) + noise) @ turn)
    assert (found is None) if told is None else (found is not None and told in found)
    assert odd_gravity(np.full((500, 3), np.nan)) is None
