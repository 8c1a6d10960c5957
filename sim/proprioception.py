"""What the robot measures of its own motion: odometry, IMU, wheel joints and battery, from the true track."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from navtool.pipeline.arrays import Array
from navtool.sim.rig import TRACK_WIDTH_M, WHEEL_RADIUS_M
from navtool.sim.robot import STEP_S
from navtool.sim.track import Track

GRAVITY_MPS2 = 9.81
IMU_EVERY, ODOMETRY_EVERY, BATTERY_EVERY = 1, 2, 10
"""Track steps between two samples: 100 Hz, 50 Hz and 10 Hz."""


class Proprioception(NamedTuple):
    """Measured streams, each at its own rate from the first step of the track on."""

    imu: Float[Array, "n 6"]
    """ax, ay, az in m/s2 (gravity on +z at rest) and wx, wy, wz in rad/s; 100 Hz, frame imu_link."""
    odometry: Float[Array, "m 5"]
    """x, y in metres and yaw in radians since the start, with drift; speed in m/s and turn in rad/s; 50 Hz."""
    joints: Float[Array, "m 3 4"]
    """Position in rad, velocity in rad/s and effort in N m of the four wheels; 50 Hz."""
    battery: Float[Array, "k 2"]
    """Current in A, negative while discharging as in ROS, and voltage in V; 10 Hz."""


def measure(track: Track, rng: np.random.Generator) -> Proprioception:
    """Return what the robot measures on a track."""
    joints = _joints(track, rng)
    return Proprioception(
        imu=_imu(track, rng),
        odometry=_odometry(track, rng)[::ODOMETRY_EVERY],
        joints=joints[::ODOMETRY_EVERY],
        battery=_battery(track, joints[:, 2], rng)[::BATTERY_EVERY],
    )


def _imu(track: Track, rng: np.random.Generator) -> Float[Array, "n 6"]:
    """Specific force and turn rate: motion, gravity, vibration by terrain and speed, ringing after an impact."""
    steps = track.time_s.size
    forward = np.diff(track.speed_mps, append=track.speed_mps[-1]) / STEP_S
    tilt_x = -np.sin(track.pitch_rad)
    tilt_y = np.sin(track.roll_rad) * np.cos(track.pitch_rad)
    tilt_z = np.cos(track.roll_rad) * np.cos(track.pitch_rad)
    force = GRAVITY_MPS2 * np.stack([tilt_x, tilt_y, tilt_z], axis=-1)
    force[:, 0] += forward
    force[:, 1] += track.speed_mps * track.turn_radps
    vibration = 0.05 + track.roughness * np.abs(track.speed_mps)
    force += vibration[:, None] * np.array([0.4, 0.4, 1.0]) * rng.standard_normal((steps, 3))
    since = np.arange(30) * STEP_S
    ringing = np.exp(-since / 0.07) * np.sin(2 * np.pi * 18.0 * since)
    blow = np.where(track.contact, np.abs(forward), 0.0)
    force += np.convolve(blow, ringing)[:steps, None] * np.array([0.1, 0.0, 0.15])
    rates = np.stack([np.gradient(track.roll_rad, STEP_S), np.gradient(track.pitch_rad, STEP_S), track.turn_radps])
    bias = rng.normal(0.0, 0.002, 3)
    return np.concatenate([force, rates.T + bias + rng.normal(0.0, 0.008, (steps, 3))], axis=-1)


def _odometry(track: Track, rng: np.random.Generator) -> Float[Array, "n 5"]:
    """Wheel odometry: the measured twist, integrated, with a constant scale error and noise."""
    steps = track.time_s.size
    speed = track.speed_mps * (1 + rng.normal(0.0, 0.008)) + rng.normal(0.0, 0.004, steps)
    turn = track.turn_radps * (1 + rng.normal(0.0, 0.012)) + rng.normal(0.0, 0.006, steps)
    yaw = np.cumsum(turn) * STEP_S
    x, y = np.cumsum(speed * np.cos(yaw)) * STEP_S, np.cumsum(speed * np.sin(yaw)) * STEP_S
    return np.stack([x, y, yaw, speed, turn], axis=-1)


def _joints(track: Track, rng: np.random.Generator) -> Float[Array, "n 3 4"]:
    """Wheels left, right, left, right; they push hardest where the robot does not follow its command."""
    side = np.array([-1.0, 1.0, -1.0, 1.0]) * TRACK_WIDTH_M / 2
    velocity = (track.speed_mps[:, None] + side * track.turn_radps[:, None]) / WHEEL_RADIUS_M
    position = np.cumsum(velocity, axis=0) * STEP_S
    wanted = (track.command_mps[:, None] + side * track.command_radps[:, None]) / WHEEL_RADIUS_M
    rolling = (0.5 + 0.8 * track.roughness[:, None]) * np.tanh(velocity / 0.2)
    effort = rolling + np.clip(2.5 * (wanted - velocity), -12.0, 12.0)
    noise = rng.normal(0.0, 1.0, (2, *velocity.shape))
    return np.stack([position, velocity + 0.02 * noise[0], effort + 0.15 * noise[1]], axis=1)


def _battery(track: Track, effort: Float[Array, "n 4"], rng: np.random.Generator) -> Float[Array, "n 2"]:
    """Electronics, plus a share of the wheels' effort; the voltage sags with the current."""
    current = 2.2 + 0.35 * np.abs(effort).sum(axis=1) + rng.normal(0.0, 0.08, track.time_s.size)
    smooth = np.convolve(np.pad(current, (9, 0), mode="edge"), np.full(10, 0.1), mode="valid")
    return np.stack([-smooth, 26.4 - 0.04 * smooth - 0.0005 * track.time_s], axis=-1)
