"""What the wheeled robot measures of itself: IMU, wheels, odometry and battery, each at its own rate."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Float64

from navtool.base.setting_checks import outside
from navtool.base.setting_error import refuse
from navtool.pipeline.arrays import Array
from navtool.pipeline.geometry.transforms import transform_from_xyz_quaternion
from navtool.sim.drive.drive import Measured
from navtool.sim.wheeled.config import BASE_HEIGHT_M, GRAVITY_MPS2, STEP_S, WheeledConfig
from navtool.sim.wheeled.samples import Samples
from navtool.sim.world.surfaces import surface_values

IMU_EVERY, JOINTS_EVERY, ODOMETRY_EVERY, BATTERY_EVERY = 1, 2, 2, 10
"""Steps between two samples: 100 Hz, 50 Hz, 50 Hz and 10 Hz."""
_PURPOSE = 61
_RING_HZ, _RING_S, _RING_SAMPLES = 18.0, 0.07, 40


@dataclass(kw_only=True, slots=True)
class SensorConfig:
    """Errors of the robot's own sensors; deviations of normal noise and of constants drawn once a drive.

    The IMU's are those of a MEMS unit of the class that robots carry (0.14 mg and 0.0035 degrees/s over the root of a
    hertz, at 100 Hz); the battery is the Husky's: 24 V, 20 Ah, lead acid; the others are chosen.
    """

    force_noise_mps2: float = 0.01
    force_bias_mps2: float = 0.03
    rate_noise_radps: float = 0.0005
    rate_bias_radps: float = 0.002
    shake_per_s2: float = 40.0
    """Acceleration of the shaking for a metre of the ground's relief and a metre a second: what is shorter than a cell
    of the ground, which the tyres filter; half of it sideways and lengthwise."""
    motor_shake_mps2: float = 0.05
    """Acceleration of the shaking by motors and gears while the wheels turn."""
    ring: float = 0.15
    """Share of a blow that the body's frame passes on in each axis, ringing."""
    scale: float = 0.008
    """Relative error of the wheels' radius: tyres' pressure and load."""
    track_scale: float = 0.02
    """Relative error of the track's multiplier."""
    wheel_noise_mps: float = 0.004
    """Noise of a wheel's measured speed."""
    effort_scale: float = 0.03
    """Relative error of a side's torque."""
    effort_noise_nm: float = 0.1
    full_v: float = 25.6
    """At no load when fully charged."""
    empty_v: float = 23.4
    """At no load when all of the energy is drawn."""
    energy_wh: float = 480.0
    resistance_ohm: float = 0.04
    current_noise_a: float = 0.05

    def __post_init__(self) -> None:
        battery = ("energy_wh", "resistance_ohm")
        noise = (name for name in self.__slots__ if name not in battery)
        refuse(outside(self, 0, math.inf, *noise), outside(self, 0, math.inf, *battery, above=True))


class Proprioception(NamedTuple):
    """Measured streams, as `Drive` describes them."""

    imu: Measured
    joints: Measured
    odometry: Measured
    battery: Measured


def measure(samples: Samples, seed: int, body: WheeledConfig, config: SensorConfig) -> Proprioception:
    """What the robot measures on a drive; equal arguments give equal numbers."""
    rng = np.random.default_rng([seed, _PURPOSE])
    wheel = _measured_wheels(samples, config, rng)
    return Proprioception(
        imu=_every(IMU_EVERY, _imu(samples, config, rng)),
        joints=_every(JOINTS_EVERY, _joints(samples, wheel, config, rng)),
        odometry=_every(ODOMETRY_EVERY, _odometry(wheel, body, config, rng)),
        battery=_battery(samples, config, rng),
    )


def specific_force_mps2(samples: Samples) -> Float64[Array, "n 3"]:
    """What a perfect IMU in base_link feels of motion and gravity, body's axes; the mean of each step."""
    velocity = samples.velocity_mps()
    force = np.diff(velocity, axis=0, prepend=velocity[:1]) / STEP_S
    force[:, 2] += GRAVITY_MPS2
    rotation = transform_from_xyz_quaternion(samples.ground_m, samples.quaternion())[:, :3, :3]
    return np.asarray(np.einsum("nji,nj->ni", rotation, force))


def _every(steps: int, values: Array) -> Measured:
    return Measured(np.arange(0, len(values), steps) * STEP_S, np.ascontiguousarray(values[::steps]))


def _imu(samples: Samples, config: SensorConfig, rng: np.random.Generator) -> Float64[Array, "n 6"]:
    count = len(samples)
    force = specific_force_mps2(samples)
    relief = surface_values("relief_m").astype(np.float64)[samples.surface]
    shake = config.shake_per_s2 * relief * np.abs(samples.speed_mps)
    turning = np.abs(samples.wheel_mps).max(axis=1) > 0.02
    shake = np.hypot(shake, config.motor_shake_mps2 * turning)
    blow = np.where(samples.obstacle >= 0, np.abs(np.diff(samples.speed_mps, prepend=0.0)) / STEP_S, 0.0)
    since = np.arange(1, _RING_SAMPLES + 1) * STEP_S
    ringing = np.exp(-since / _RING_S) * np.sin(2 * np.pi * _RING_HZ * since)
    force += shake[:, None] * np.array([0.5, 0.5, 1.0]) * rng.standard_normal((count, 3))
    force += config.ring * np.convolve(blow, ringing)[:count, None]
    true = np.concatenate([force, samples.rates_radps()], axis=1)
    bias = np.repeat([config.force_bias_mps2, config.rate_bias_radps], 3) * rng.standard_normal(6)
    noise = np.repeat([config.force_noise_mps2, config.rate_noise_radps], 3) * rng.standard_normal(true.shape)
    return np.asarray(true + bias + noise)


def _measured_wheels(samples: Samples, config: SensorConfig, rng: np.random.Generator) -> Float64[Array, "n 2"]:
    """Speed of the left and the right rims as the encoders measure it; a wheel at rest reads exactly 0."""
    noise = config.wheel_noise_mps * rng.standard_normal(samples.wheel_mps.shape)
    return np.asarray(samples.wheel_mps + noise * np.minimum(np.abs(samples.wheel_mps) / 0.1, 1.0))


def _joints(
    samples: Samples, wheel: Float64[Array, "n 2"], config: SensorConfig, rng: np.random.Generator
) -> Float64[Array, "n 3 4"]:
    """The two wheels of a side are geared to one drive: they turn alike, and each has half of its torque."""
    position = np.cumsum(samples.wheel_mps, axis=0) * (STEP_S / BASE_HEIGHT_M)
    scale = 1.0 + config.effort_scale * rng.standard_normal(2)
    torque = 0.5 * BASE_HEIGHT_M * samples.force_n * scale
    four = np.stack([position, wheel / BASE_HEIGHT_M, torque], axis=1)[..., [0, 1, 0, 1]]
    four[:, 2] += config.effort_noise_nm * rng.standard_normal((len(four), 4))
    return np.asarray(four)


def _odometry(
    wheel: Float64[Array, "n 2"], body: WheeledConfig, config: SensorConfig, rng: np.random.Generator
) -> Float64[Array, "n 5"]:
    """The wheels' turning summed up as if they never slipped, with errors of radius and track."""
    scale, track_scale = 1.0 + np.array([config.scale, config.track_scale]) * rng.standard_normal(2)
    speed = scale * wheel.mean(axis=1)
    turn = scale * (wheel[:, 1] - wheel[:, 0]) / (body.track_m * body.track_multiplier * track_scale)
    yaw = np.cumsum(turn) * STEP_S
    middle = yaw - 0.5 * turn * STEP_S
    x, y = np.cumsum(speed * np.cos(middle)) * STEP_S, np.cumsum(speed * np.sin(middle)) * STEP_S
    return np.stack([x, y, yaw, speed, turn], axis=-1)


def _battery(samples: Samples, config: SensorConfig, rng: np.random.Generator) -> Measured:
    """Means over the time since the last sample."""
    whole = (len(samples) - 1) // BATTERY_EVERY
    power = samples.power_w[1 : 1 + whole * BATTERY_EVERY].reshape(whole, BATTERY_EVERY).mean(axis=1)
    each_s = BATTERY_EVERY * STEP_S
    drawn_wh = np.cumsum(power) * each_s / 3600.0
    open_v = config.full_v - (config.full_v - config.empty_v) * np.minimum(drawn_wh / config.energy_wh, 1.0)
    root = np.sqrt(np.maximum(open_v * open_v - 4.0 * config.resistance_ohm * power, 0.0))
    current = (open_v - root) / (2.0 * config.resistance_ohm)
    voltage = open_v - config.resistance_ohm * current
    noisy = -current + config.current_noise_a * rng.standard_normal(whole)
    return Measured(each_s * np.arange(1, whole + 1), np.stack([noisy, voltage], axis=-1))
