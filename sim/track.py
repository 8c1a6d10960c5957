"""What really happened on a drive: the robot's motion, its commands and its failures, at 100 Hz."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from navtool.pipeline.arrays import Array
from navtool.pipeline.geometry.transforms import transform_from_xyz_rpy
from navtool.sim.driver import Driver, Mode
from navtool.sim.errors import SimError
from navtool.sim.ground import ROUGHNESS
from navtool.sim.robot import STEP_S, Robot, RobotLimits, RobotState
from navtool.sim.scene import REACH_M, Scene

_DECIDE_EVERY = 5
"""Steps between two decisions of the driver: 20 Hz."""
_GRAVITY_SHAKE_RAD = 0.012


@dataclass(frozen=True, slots=True)
class Failure:
    """A stretch of the drive that failed."""

    start_s: float
    end_s: float
    reason: str
    """collision or stuck."""


@dataclass(frozen=True, slots=True)
class Track:
    """The truth of a drive, one entry a step of 10 ms. World frame, SI units."""

    time_s: Float[Array, "n"]
    x_m: Float[Array, "n"]
    y_m: Float[Array, "n"]
    yaw_rad: Float[Array, "n"]
    """Continuous: not wrapped."""
    roll_rad: Float[Array, "n"]
    pitch_rad: Float[Array, "n"]
    speed_mps: Float[Array, "n"]
    turn_radps: Float[Array, "n"]
    command_mps: Float[Array, "n"]
    command_radps: Float[Array, "n"]
    contact: Bool[Array, "n"]
    intervention: Bool[Array, "n"]
    roughness: Float[Array, "n"]
    """Of the terrain underneath; 1 is gravel."""
    failures: tuple[Failure, ...]

    def pose(self, time_s: Float[Array, "m"]) -> Float[Array, "m 4 4"]:
        """Return the footprint's pose in the world at times, linear between steps and constant beyond the ends."""
        at = [np.interp(time_s, self.time_s, values) for values in (self.x_m, self.y_m)]
        turned = [np.interp(time_s, self.time_s, v) for v in (self.roll_rad, self.pitch_rad, self.yaw_rad)]
        return transform_from_xyz_rpy(np.stack([*at, np.zeros(time_s.shape)], axis=-1), np.stack(turned, axis=-1))

    @property
    def failed_share(self) -> float:
        """Share of the drive's duration that failed, 0-1."""
        return sum(failure.end_s - failure.start_s for failure in self.failures) / float(self.time_s[-1])


def drive(scene: Scene, seed: int, seconds: float, mischief: float = 0.5) -> Track:
    """Drive about a scene.

    Args:
        scene: Where to drive.
        seed: Decides start, driver and terrain shake; equal arguments give equal tracks.
        seconds: Duration, 1 to 3600.
        mischief: Share of the driver's legs that lead into an obstacle, 0-1.

    Raises:
        SimError: An argument is out of range, or the scene has no room to start in.
    """
    if seed < 0 or not 1.0 <= seconds <= 3600.0 or not 0.0 <= mischief <= 1.0:
        what = f"a drive needs seed >= 0, 1 to 3600 seconds and 0 <= mischief <= 1, got {seed}, {seconds}, {mischief}"
        raise SimError(what, cure="ask for a drive within these bounds")
    rng = np.random.default_rng(seed)
    obstacles = scene.obstacles()
    robot = Robot(obstacles, RobotLimits())
    driver = Driver(robot, obstacles, mischief, rng)
    state = _start(robot, rng)
    command = driver.command(0.0, state)
    steps = round(seconds / STEP_S)
    rows, modes = np.zeros((steps, 8)), []
    for step in range(steps):
        if step % _DECIDE_EVERY == 0:
            command = driver.command(step * STEP_S, state)
        held = (command.speed_mps, command.turn_radps, command.intervention)
        rows[step] = (state.x_m, state.y_m, state.yaw_rad, state.speed_mps, state.turn_radps, *held)
        modes.append((driver.mode, state.contact))
        state = robot.step(state, command.speed_mps, command.turn_radps, lifted=command.intervention)
    x, y, yaw, speed, turn, command_speed, command_turn, intervention = np.ascontiguousarray(rows.T)
    roughness = ROUGHNESS[scene.ground.terrain_at(x, y)]
    shake = _GRAVITY_SHAKE_RAD * roughness * (0.1 + np.abs(speed))
    return Track(
        time_s=np.arange(steps) * STEP_S,
        x_m=x,
        y_m=y,
        yaw_rad=yaw,
        roll_rad=shake * _slow_noise(rng, steps),
        pitch_rad=shake * _slow_noise(rng, steps),
        speed_mps=speed,
        turn_radps=turn,
        command_mps=command_speed,
        command_radps=command_turn,
        contact=np.array([contact for _, contact in modes]),
        intervention=intervention > 0,
        roughness=roughness,
        failures=_failures(modes, speed),
    )


def _start(robot: Robot, rng: np.random.Generator) -> RobotState:
    places = rng.uniform(-0.7 * REACH_M, 0.7 * REACH_M, (2, 400))
    free = np.flatnonzero(robot.clearance(places) > 0.8)
    if not free.size:
        raise SimError("no room for the robot to start in", where="scene", cure="use another seed or place")
    x, y = places[:, free[0]]
    return RobotState(x_m=float(x), y_m=float(y), yaw_rad=float(rng.uniform(-np.pi, np.pi)))


def _slow_noise(rng: np.random.Generator, steps: int) -> Float[Array, "n"]:
    """Return noise of unit deviation that changes within about 0.15 s."""
    window = np.hanning(32)
    noise = np.convolve(rng.standard_normal(steps + window.size - 1), window, mode="valid")
    return np.asarray(noise / np.sqrt((window**2).sum()))


def _failures(modes: list[tuple[Mode, bool]], speed: Float[Array, "n"]) -> tuple[Failure, ...]:
    """Return collisions, from contact until the robot backs off, and getting stuck, until the operator has freed it."""
    failures: list[Failure] = []
    start, reason = 0, ""
    for step, (mode, contact) in enumerate(modes):
        if not reason:
            reason = "collision" if contact else "stuck" if mode is Mode.STUCK else ""
            start = step
        elif reason == "collision":
            over = mode in {Mode.BACK_OFF, Mode.CRUISE} and not contact and abs(speed[step]) > 0.05
        else:
            over = mode is Mode.CRUISE
        if reason and step > start and over:
            failures.append(Failure(start * STEP_S, step * STEP_S, reason))
            reason = ""
    if reason:
        failures.append(Failure(start * STEP_S, len(modes) * STEP_S, reason))
    return tuple(failures)
