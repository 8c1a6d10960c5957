"""What the quadruped measures of itself: joints, IMU, odometry, feet and battery, each at its own rate."""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float64
from scipy.signal import butter, sosfilt, sosfilt_zi

from navtool.base.setting_checks import outside
from navtool.base.setting_error import refuse
from navtool.pipeline.arrays import Array
from navtool.sim.legged.battery import BatteryConfig, current_and_voltage, drawn_power
from navtool.sim.legged.body import STEP_S
from navtool.sim.legged.leg_odometry import leg_odometry
from navtool.sim.legged.samples import Samples

IMU_EVERY, JOINTS_EVERY, ODOMETRY_EVERY, BATTERY_EVERY = 2, 2, 10, 50
"""Physics steps between two samples: 250 Hz, 250 Hz, 50 Hz and 10 Hz."""
_PURPOSE = 51


@dataclass(kw_only=True, slots=True)
class SensorConfig:
    """Errors of the robot's own sensors; deviations of normal noise and of constants drawn once a drive.

    The IMU's are those of a MEMS unit of the class that robots carry (0.14 mg and 0.0035 degrees/s over the root of a
    hertz); the others are chosen.
    """

    bandwidth_hz: float = 80.0
    """Where the IMU's low-pass filter of second order begins to cut; 1 to 200."""
    force_noise_mps2: float = 0.0154
    force_bias_mps2: float = 0.03
    rate_noise_radps: float = 0.0007
    rate_bias_radps: float = 0.002
    joint_noise_rad: float = 2e-4
    joint_rate_noise_radps: float = 0.02
    torque_noise_nm: float = 0.4
    torque_scale: float = 0.02
    """Relative error of a joint's torque, constant."""
    touch_n: float = 20.0
    """A foot that presses harder than this is reported as standing."""
    current_noise_a: float = 0.05
    battery: BatteryConfig = field(default_factory=BatteryConfig)

    def __post_init__(self) -> None:
        refuse(outside(self, 1, 200, "bandwidth_hz", unit="Hz"))


class Proprioception(NamedTuple):
    """Measured streams; row k of a stream that is sampled every m steps belongs to the time k m `STEP_S`."""

    imu: Float64[Array, "n 6"]
    """Specific force in m/s2 (at rest 9.81 upwards) and turn rates in rad/s, body's axes; 250 Hz."""
    joints: Float64[Array, "n 3 12"]
    """Position in rad, velocity in rad/s and effort in N m, in the order of `body.JOINT_NAMES`; 250 Hz."""
    feet: Bool[Array, "n 4"]
    """Which feet stand, in the order of `body.LEGS`; 250 Hz."""
    odometry: Float64[Array, "m 5"]
    """x, y in metres and yaw in radians since the start, with drift; forward speed and turn; 50 Hz."""
    battery: Float64[Array, "k 2"]
    """Current in A, negative while discharging as in ROS, and voltage in V, means over the tenth of a second before
    the sample; 10 Hz, the first row a tenth of a second after the reset."""


def measure(samples: Samples, seed: int, config: SensorConfig | None = None) -> Proprioception:
    """Return what the robot measures on a drive; equal arguments give equal numbers."""
    config = config or SensorConfig()
    rng = np.random.default_rng([seed, _PURPOSE])
    imu = _imu(samples, config, rng)
    joints = _joints(samples, config, rng)
    odometry = leg_odometry(joints[:, 0], joints[:, 1], samples.foot_force_n, imu[:, 3:], samples.quaternion, STEP_S)
    return Proprioception(
        imu=imu[::IMU_EVERY],
        joints=joints[::JOINTS_EVERY],
        feet=(samples.foot_force_n > config.touch_n)[::JOINTS_EVERY],
        odometry=odometry[::ODOMETRY_EVERY],
        battery=_battery(samples, config, rng),
    )


def _imu(samples: Samples, config: SensorConfig, rng: np.random.Generator) -> Float64[Array, "n 6"]:
    true = np.concatenate([samples.specific_force_mps2, samples.rates_radps], axis=1)
    filters = butter(2, config.bandwidth_hz, fs=1.0 / STEP_S, output="sos")
    start = sosfilt_zi(filters)[..., None] * true[0]
    passed, _ = sosfilt(filters, true, axis=0, zi=start)
    bias = np.repeat([config.force_bias_mps2, config.rate_bias_radps], 3) * rng.standard_normal(6)
    noise = np.repeat([config.force_noise_mps2, config.rate_noise_radps], 3) * rng.standard_normal(true.shape)
    return np.asarray(passed + bias + noise)


def _joints(samples: Samples, config: SensorConfig, rng: np.random.Generator) -> Float64[Array, "n 3 12"]:
    count = len(samples.joint_rad)
    noise = rng.standard_normal((3, count, 12))
    effort = samples.torque_nm * (1.0 + config.torque_scale * rng.standard_normal(12))
    return np.stack(
        [
            samples.joint_rad + config.joint_noise_rad * noise[0],
            samples.joint_radps + config.joint_rate_noise_radps * noise[1],
            effort + config.torque_noise_nm * noise[2],
        ],
        axis=1,
    )


def _battery(samples: Samples, config: SensorConfig, rng: np.random.Generator) -> Float64[Array, "k 2"]:
    power = drawn_power(samples.torque_nm[1:], samples.joint_radps[1:], config.battery)
    whole = len(power) // BATTERY_EVERY
    power = power[: whole * BATTERY_EVERY].reshape(whole, BATTERY_EVERY).mean(axis=1)
    current, voltage = current_and_voltage(power, STEP_S * BATTERY_EVERY, config.battery)
    return np.stack([-current + config.current_noise_a * rng.standard_normal(whole), voltage], axis=-1)
