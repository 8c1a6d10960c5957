"""What the physics did, step by step, as the sensors and the judgement of failures need it."""

from dataclasses import dataclass
from typing import Any, NamedTuple

import mujoco
import numpy as np
from jaxtyping import Bool, Float64, Int64

from navtool.pipeline.arrays import Array
from navtool.pipeline.geometry.transforms import transform_from_xyz_quaternion
from navtool.sim.legged.body import HIPS_M, SIDES
from navtool.sim.legged.leg_kinematics import foot_in_leg

_STEP_COLUMNS = 59
_FIRST_ROWS = 4096


@dataclass(frozen=True, slots=True)
class Samples:
    """The reset's state and one entry a physics step (`body.STEP_S`) from there on. World frame, SI units."""

    position_m: Float64[Array, "n 3"]
    """Positions of the body's middle."""
    quaternion: Float64[Array, "n 4"]
    """Attitudes of the body: x, y, z, w."""
    velocity_mps: Float64[Array, "n 3"]
    """Velocities of the body's middle, world axes."""
    rates_radps: Float64[Array, "n 3"]
    """Body's axes."""
    joint_rad: Float64[Array, "n 12"]
    joint_radps: Float64[Array, "n 12"]
    torque_nm: Float64[Array, "n 12"]
    """Torques of the motors, at the joints."""
    specific_force_mps2: Float64[Array, "n 3"]
    """At the IMU, body's axes: at rest it points up."""
    foot_force_n: Float64[Array, "n 4"]
    """How hard each foot presses against the ground."""
    command: Float64[Array, "n 2"]
    """Speed and turn asked for."""
    freed: Bool[Array, " n"]
    """Whether the operator frees the robot from what grows and lies there."""
    standing: Bool[Array, "n 4"]
    """Which feet the controller has on the ground."""
    drag_n: Float64[Array, " n"]
    """How hard plants and mud hold the legs and the body."""
    stumbles: Int64[Array, " n"]
    """How many steps were caught on something so far."""
    obstacle: Int64[Array, " n"]
    """Number of the obstacle that is touched, -1 for none."""
    trunk_down: Bool[Array, " n"]
    """Whether the trunk lies on the ground."""
    fallen: Bool[Array, " n"]

    def foot_m(self) -> Float64[Array, "n 4 3"]:
        """Return the feet's centres in the world, by leg."""
        count = len(self.joint_rad)
        legs = foot_in_leg(self.joint_rad.reshape(count, 4, 3), np.broadcast_to(SIDES, (count, 4)))
        pose = transform_from_xyz_quaternion(self.position_m, self.quaternion)
        return np.asarray((HIPS_M + legs) @ np.swapaxes(pose[:, :3, :3], 1, 2) + pose[:, None, :3, 3])


class Tick(NamedTuple):
    """What holds for all physics steps between two decisions of the controller: the fields of `Samples`."""

    command: tuple[float, float]
    standing: tuple[bool, ...]
    obstacle: int
    freed: bool = False
    drag_n: float = 0.0
    stumbles: int = 0
    trunk_down: bool = False
    fallen: bool = False


class Recorder:
    """Collects samples in blocks that grow.

    Args:
        data: What the physics step changes.
        steps: Physics steps a tick of the controller.
    """

    def __init__(self, data: mujoco.MjData, steps: int) -> None:
        self._sources = (data.qpos, data.qvel, data.qfrc_actuator[6:], data.sensordata)
        self._ends = (19, 37, 49, _STEP_COLUMNS)
        self._steps: Array = np.empty((_FIRST_ROWS, _STEP_COLUMNS))
        self._ticks: list[Tick] = []
        self._each = steps
        self._rows = 0

    @property
    def count(self) -> int:
        """Physics steps so far."""
        return max(0, self._rows - 1)

    def begin(self, tick: Tick) -> None:
        """Take the state of the reset."""
        self.step()
        self.tick(tick)

    def step(self) -> None:
        """Take the state after a physics step."""
        if self._rows == len(self._steps):
            self._steps = np.concatenate([self._steps, np.empty_like(self._steps)])
        row, start = self._steps[self._rows], 0
        for source, end in zip(self._sources, self._ends, strict=True):
            row[start:end] = source
            start = end
        self._rows += 1

    def tick(self, tick: Tick) -> None:
        """Take what held for the physics steps since the last tick."""
        self._ticks.append(tick)

    def samples(self) -> Samples:
        """Return all of it so far."""
        steps = self._steps[: self._rows].copy()
        return Samples(
            position_m=steps[:, :3],
            quaternion=steps[:, [4, 5, 6, 3]],
            velocity_mps=steps[:, 19:22],
            rates_radps=steps[:, 22:25],
            joint_rad=steps[:, 7:19],
            joint_radps=steps[:, 25:37],
            torque_nm=steps[:, 37:49],
            specific_force_mps2=steps[:, 49:52],
            foot_force_n=steps[:, 55:59],
            command=self._each_step([tick.command for tick in self._ticks], np.float64, 2),
            freed=self._each_step([tick.freed for tick in self._ticks], np.bool_),
            standing=self._each_step([tick.standing for tick in self._ticks], np.bool_, 4),
            drag_n=self._each_step([tick.drag_n for tick in self._ticks], np.float64),
            stumbles=self._each_step([tick.stumbles for tick in self._ticks], np.int64),
            obstacle=self._each_step([tick.obstacle for tick in self._ticks], np.int64),
            trunk_down=self._each_step([tick.trunk_down for tick in self._ticks], np.bool_),
            fallen=self._each_step([tick.fallen for tick in self._ticks], np.bool_),
        )

    def _each_step(self, values: list[Any], dtype: type, *columns: int) -> Array:
        """Return one row a physics step from one value a tick."""
        rows = np.full(len(values), self._each)
        rows[0] = 1
        return np.repeat(np.array(values, dtype).reshape(-1, *columns), rows, axis=0)
