"""A drive's poses and its failed share."""

import numpy as np

from navtool.pipeline.geometry.transforms import quaternion_from_rpy, rpy_from_transform
from navtool.sim.drive.drive import Drive, Measured
from navtool.sim.drive.failure import Failure, FailureKind

STEP_S = 0.01


def circle(failures: tuple[Failure, ...] = (), steps: int = 501) -> Drive:
    """A drive on a circle of 2 m at 1 m/s."""
    time_s = np.arange(steps) * STEP_S
    yaw = 0.5 * time_s
    empty = Measured(np.zeros(0), np.zeros((0, 6)))
    return Drive(
        time_s=time_s,
        position_m=np.stack([2 * np.sin(yaw), 2 - 2 * np.cos(yaw), np.zeros(steps)], axis=1),
        quaternion=quaternion_from_rpy(np.stack([0 * yaw, 0 * yaw, yaw], axis=1)),
        velocity_mps=np.tile([1.0, 0.0, 0.0], (steps, 1)),
        rates_radps=np.tile([0.0, 0.0, 0.5], (steps, 1)),
        command=np.tile([1.0, 0.5], (steps, 1)),
        intervention=np.zeros(steps, bool),
        imu=empty,
        joints=empty,
        joint_names=(),
        odometry=empty,
        battery=empty,
        failures=failures,
    )


def test_poses_between_steps_lie_on_the_way() -> None:
    at = np.array([0.0, 0.0125, 1.2345, 4.999])
    pose = circle().pose(at)
    np.testing.assert_allclose(rpy_from_transform(pose)[:, 2], 0.5 * at, atol=1e-9)
    np.testing.assert_allclose(pose[:, 0, 3], 2 * np.sin(0.5 * at), atol=1e-4)


def test_beyond_its_ends_a_drive_stands_still() -> None:
    drive = circle()
    np.testing.assert_array_equal(drive.pose(np.array([-1.0, 99.0])), drive.pose(np.array([0.0, drive.duration_s])))


def test_failures_at_once_count_once() -> None:
    two = (
        Failure(FailureKind.stuck, 1.0, 3.0, 0.0, 0.0, "no headway"),
        Failure(FailureKind.collision, 2.0, 3.5, 0.0, 0.0, "against a wall"),
    )
    assert abs(circle(two).failed_share - 0.5) < 0.01
    assert circle().failed_share == 0.0
