import dataclasses
from collections.abc import Callable

import numpy as np
import pytest
from legged_walk import walk_straight

from navtool.base.setting_error import SettingError
from navtool.sim.legged.body import JOINT_NAMES
from navtool.sim.legged.footings import concrete
from navtool.sim.legged.gaits import GaitName
from navtool.sim.legged.proprioception import JOINTS_EVERY, SensorConfig, measure
from navtool.sim.legged.robot import LeggedRobot
from navtool.sim.legged.track import LeggedTrack


def test_every_stream_has_its_rate_and_shape(on_concrete: Callable[[GaitName], LeggedTrack]) -> None:
    measured = on_concrete(GaitName.TROT).measured
    assert measured.imu.shape == (1251, 6)
    assert measured.joints.shape == (1251, 3, len(JOINT_NAMES))
    assert measured.feet.shape == (1251, 4)
    assert measured.odometry.shape == (251, 5)
    assert measured.battery.shape == (50, 2)
    assert (measured.battery[:, 0] < 0).all(), "discharging is negative in ROS"


def test_at_rest_the_imu_feels_gravity_upwards() -> None:
    robot = LeggedRobot(concrete())
    robot.step(0.0, 0.0, 2.0)
    imu = measure(robot.samples(), seed=3).imu[250:]
    assert imu.mean(axis=0) == pytest.approx([0, 0, 9.81, 0, 0, 0], abs=0.12)
    assert imu[:, :3].std(axis=0) == pytest.approx(np.full(3, SensorConfig().force_noise_mps2), rel=0.3)


def test_without_errors_the_joints_are_measured_as_they_are(on_concrete: Callable[[GaitName], LeggedTrack]) -> None:
    truth = on_concrete(GaitName.CRAWL).truth
    exact = SensorConfig(joint_noise_rad=0.0, joint_rate_noise_radps=0.0, torque_noise_nm=0.0, torque_scale=0.0)
    joints = measure(truth, seed=1, config=exact).joints
    assert np.array_equal(joints[:, 0], truth.joint_rad[::JOINTS_EVERY])
    assert np.array_equal(joints[:, 2], truth.torque_nm[::JOINTS_EVERY])


def test_equal_seeds_give_equal_measurements(on_concrete: Callable[[GaitName], LeggedTrack]) -> None:
    truth = on_concrete(GaitName.TROT).truth
    first, second, other = measure(truth, 1), measure(truth, 1), measure(truth, 2)
    assert all(np.array_equal(a, b) for a, b in zip(first, second, strict=True))
    assert not np.array_equal(first.imu, other.imu)


@pytest.mark.parametrize("gait", list(GaitName))
def test_on_hard_ground_the_odometry_drifts_little(
    gait: GaitName, on_concrete: Callable[[GaitName], LeggedTrack]
) -> None:
    track = on_concrete(gait)
    went = np.hypot(*track.truth.position_m[-1, :2])
    assert np.hypot(*(track.measured.odometry[-1, :2] - track.truth.position_m[-1, :2])) < 0.05 * went


def test_feet_that_slide_deceive_the_odometry(on_concrete: Callable[[GaitName], LeggedTrack]) -> None:
    ice = dataclasses.replace(concrete(), friction=0.22)
    errors = []
    for track in (on_concrete(GaitName.TROT), walk_straight(LeggedRobot(ice), 5.0, 0.5)):
        moved = track.truth.position_m[-1, :2] - track.truth.position_m[0, :2]
        errors.append(np.hypot(*(track.measured.odometry[-1, :2] - moved)))
    assert errors[1] > 1.5 * errors[0]


def test_the_imus_filter_has_bounds() -> None:
    with pytest.raises(SettingError, match="300"):
        SensorConfig(bandwidth_hz=300.0)
