"""What the robot measures of itself agrees with what happened, within its sensors' errors."""

from collections.abc import Callable

import numpy as np
import pytest

from navtool.base.setting_error import SettingError
from navtool.pipeline.geometry.transforms import quaternion_to_rpy, transform_from_xyz_quaternion
from navtool.sim.wheeled.config import BASE_HEIGHT_M, GRAVITY_MPS2, WHEELS
from navtool.sim.wheeled.proprioception import SensorConfig, specific_force_mps2
from navtool.sim.wheeled.robot import WheeledRobot
from navtool.sim.world.obstacle import Obstacle
from navtool.sim.world.place import World
from navtool.sim.world.surfaces import surface_number

Place = Callable[..., World]
Run = Callable[..., WheeledRobot]
QUIET = SensorConfig(
    **dict.fromkeys(
        (
            *("force_noise_mps2", "force_bias_mps2", "rate_noise_radps", "rate_bias_radps", "shake_per_s2"),
            *("motor_shake_mps2", "scale", "track_scale", "wheel_noise_mps", "effort_scale", "effort_noise_nm"),
            "current_noise_a",
        ),
        0.0,
    )
)


def test_at_rest_on_a_slope_the_imu_measures_gravity_turned(place: Place) -> None:
    robot = WheeledRobot(place("concrete", lambda x, y: 0.2 * x - 0.1 * y), sensors=QUIET)
    robot.reset(1.0, 1.0, 0.6)
    robot.step(0.0, 0.0, 2.0)
    drive = robot.drive(1)
    up = transform_from_xyz_quaternion(drive.position_m, drive.quaternion)[:, 2, :3]
    np.testing.assert_allclose(drive.imu.values[:, :3], GRAVITY_MPS2 * up, atol=1e-6)
    np.testing.assert_allclose(drive.imu.values[:, 3:], 0.0, atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(drive.imu.values[:, :3], axis=1), GRAVITY_MPS2, atol=1e-6)


def test_in_a_curve_it_feels_the_centripetal_force_and_the_turn(place: Place) -> None:
    robot = WheeledRobot(place(), sensors=QUIET)
    robot.reset(0.0, 0.0, 0.0)
    robot.step(0.8, 0.5, 6.0)
    imu = robot.drive(1).imu.values[300:]
    np.testing.assert_allclose(imu[:, :3], np.tile([0.0, 0.8 * 0.5, GRAVITY_MPS2], (len(imu), 1)), atol=0.02)
    np.testing.assert_allclose(imu[:, 3:], np.tile([0.0, 0.0, 0.5], (len(imu), 1)), atol=2e-3)


def test_its_force_and_rates_add_up_to_its_motion(place: Place, run: Run) -> None:
    world = place("asphalt", lambda x, y: 0.1 * np.sin(x) * np.cos(0.7 * y))
    robot = run(world, (3.0, 0.8, 0.3), (3.0, 0.5, -0.5))
    samples, drive = robot.samples(), robot.drive(1)
    rotation = transform_from_xyz_quaternion(drive.position_m, drive.quaternion)[:, :3, :3]
    world_force = np.einsum("nij,nj->ni", rotation, specific_force_mps2(samples)) - [0.0, 0.0, GRAVITY_MPS2]
    velocity = np.cumsum(world_force, axis=0) * 0.01
    place_m = drive.position_m[0] + np.cumsum(velocity, axis=0) * 0.01
    np.testing.assert_allclose(place_m, drive.position_m, atol=0.03)
    body = np.einsum("nij,nj->ni", rotation, drive.velocity_mps)
    np.testing.assert_allclose(body[1:-1], (drive.position_m[2:] - drive.position_m[:-2]) / 0.02, atol=0.05)
    yaw = quaternion_to_rpy(drive.quaternion)[:, 2]
    turned = np.unwrap(yaw)
    np.testing.assert_allclose(np.gradient(turned, 0.01)[2:-2], samples.turn_radps[2:-2], atol=0.04)


def test_faster_and_rougher_shakes_more(place: Place, run: Run) -> None:
    def shaken(surface: str, speed: float) -> float:
        drive = run(place(surface), (6.0, speed, 0.0), start=(-6.0, 0.0, 0.0)).drive(2)
        return float(drive.imu.values[100:, 2].std())

    assert shaken("concrete", 0.8) < shaken("gravel", 0.8) < shaken("rock_bed", 0.8)
    assert shaken("gravel", 0.3) < shaken("gravel", 0.8)


def test_a_blow_is_a_spike_and_rings(place: Place, run: Run) -> None:
    wall = Obstacle(
        kind="wall",
        surface=surface_number("brick"),
        x_m=2.0,
        y_m=0.0,
        half_length_m=2.0,
        half_width_m=0.1,
        yaw_rad=np.pi / 2,
        height_m=2.0,
    )
    robot = run(place(things=[wall]), (4.0, 0.6, 0.0))
    imu, hit = robot.drive(1).imu, int(np.argmax(robot.samples().obstacle >= 0))
    assert imu.values[hit - 2 : hit + 3, 0].min() < -20.0
    assert np.abs(imu.values[hit + 2 : hit + 20, 2] - GRAVITY_MPS2).max() > 1.0
    assert np.abs(imu.values[: hit - 2, 0]).max() < 8.0


def test_the_wheels_turn_as_far_as_the_robot_rolls(place: Place) -> None:
    robot = WheeledRobot(place(), sensors=QUIET)
    robot.reset(-5.0, 0.0, 0.0)
    robot.step(0.7, 0.0, 8.0)
    drive = robot.drive(1)
    assert drive.joint_names == WHEELS
    assert drive.joints.values.shape[1:] == (3, 4)
    turned = drive.joints.values[-1, 0] * BASE_HEIGHT_M
    np.testing.assert_allclose(turned, drive.position_m[-1, 0] - drive.position_m[0, 0], rtol=0.01)
    work = np.abs(drive.joints.values[:, 1] * drive.joints.values[:, 2]).sum(axis=1)
    drawn = -(drive.battery.values[20:, 0] * drive.battery.values[20:, 1]).mean()
    assert drawn > robot.config.idle_w + work[200:].mean()
    robot.reset(0.0, 0.0, 0.0)
    robot.step(0.0, 0.5, 4.0)
    left, right = robot.drive(1).joints.values[-1, 0, :2]
    assert left < 0 < right


def test_odometry_stays_close_and_drifts_with_what_the_wheels_cannot_know(place: Place, run: Run) -> None:
    robot = run(place("gravel"), (8.0, 0.7, 0.2), (8.0, 0.6, -0.3))
    truth = robot.samples().ground_m[-1, :2]
    way = float(np.abs(np.diff(robot.samples().ground_m[:, :2], axis=0)).sum())
    ends = np.array([robot.drive(seed).odometry.values[-1, :2] for seed in range(20)])
    errors = np.hypot(*(ends - truth).T)
    assert 0.002 * way < errors.mean() < 0.05 * way
    assert len(np.unique(errors)) == 20
    spin = run(place("mud", lambda x, _: 0.3 * np.clip(x, 0.0, 8.0)), (6.0, 0.5, 0.0), start=(0.6, 0.0, 0.0))
    assert spin.drive(1).odometry.values[-1, 0] > spin.samples().ground_m[-1, 0] - 0.6 + 1.0


def test_streams_have_their_rates_and_the_battery_its_signs(place: Place, run: Run) -> None:
    drive = run(place(), (5.0, 0.5, 0.0)).drive(3)
    for stream, rate_hz in ((drive.imu, 100), (drive.joints, 50), (drive.odometry, 50), (drive.battery, 10)):
        assert len(stream.time_s) == len(stream.values)
        np.testing.assert_allclose(np.diff(stream.time_s), 1 / rate_hz, atol=1e-9)
        assert stream.time_s[-1] == pytest.approx(5.0, abs=0.02)
    assert (drive.battery.values[:, 0] < 0).all()
    assert (drive.battery.values[:, 1] < 25.6).all()
    with pytest.raises(SettingError, match="resistance"):
        SensorConfig(resistance_ohm=0.0)
    with pytest.raises(SettingError, match="scale"):
        SensorConfig(scale=-0.1)
