"""What the wheeled robot did, step by step, as the sensors and the judgement of failures need it."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float64, Int64

from navtool.pipeline.arrays import Array
from navtool.pipeline.geometry.transforms import quaternion_from_rpy, transform_from_xyz_quaternion
from navtool.sim.wheeled.config import BASE_HEIGHT_M, STEP_S


@dataclass(frozen=True, slots=True)
class Samples:
    """One row a step since the reset, the first one at rest. World frame, SI units."""

    rows: Float64[Array, "n columns"]

    def __len__(self) -> int:
        return len(self.rows)

    @property
    def time_s(self) -> Float64[Array, " n"]:
        """Since the reset."""
        return np.asarray(STEP_S * np.arange(len(self.rows)))

    @property
    def ground_m(self) -> Float64[Array, "n 3"]:
        """Where the middle between the wheels meets the ground."""
        return self.rows[:, 0:3]

    @property
    def rpy_rad(self) -> Float64[Array, "n 3"]:
        """Roll, pitch and yaw; the yaw is continuous."""
        return self.rows[:, 3:6]

    @property
    def speed_mps(self) -> Float64[Array, " n"]:
        """Along the heading and the ground."""
        return self.rows[:, 6]

    @property
    def turn_radps(self) -> Float64[Array, " n"]:
        """About the vertical."""
        return self.rows[:, 7]

    @property
    def bounce(self) -> Float64[Array, "n 3"]:
        """Rates of height, roll and pitch."""
        return self.rows[:, 8:11]

    @property
    def wheel_mps(self) -> Float64[Array, "n 2"]:
        """Speed of the left and the right wheels' rims."""
        return self.rows[:, 11:13]

    @property
    def force_n(self) -> Float64[Array, "n 2"]:
        """With which the left and the right drive push."""
        return self.rows[:, 13:15]

    @property
    def power_w(self) -> Float64[Array, " n"]:
        """Drawn from the battery."""
        return self.rows[:, 15]

    @property
    def lost_w(self) -> Float64[Array, " n"]:
        """What drives and electronics turn into heat: the power drawn, less the work that the wheels do."""
        return self.rows[:, 16]

    @property
    def command(self) -> Float64[Array, "n 2"]:
        """Speed and turn asked for."""
        return self.rows[:, 17:19]

    @property
    def freed(self) -> Bool[Array, " n"]:
        """Whether the operator frees it."""
        return np.asarray(self.rows[:, 19] > 0)

    @property
    def obstacle(self) -> Int64[Array, " n"]:
        """Number of the obstacle that it pushes against, -1 for none."""
        return self.rows[:, 20].astype(np.int64)

    @property
    def held(self) -> Bool[Array, " n"]:
        """Whether something soft takes most of its speed."""
        return np.asarray(self.rows[:, 21] > 0)

    @property
    def spins(self) -> Bool[Array, " n"]:
        """Whether tyres slide under their drives."""
        return np.asarray(self.rows[:, 22] > 0)

    @property
    def surface(self) -> Int64[Array, " n"]:
        """Number of the surface under the wheel that rolls hardest."""
        return self.rows[:, 23].astype(np.int64)

    @property
    def fallen(self) -> Bool[Array, " n"]:
        """Whether it has tipped over."""
        return np.asarray(self.rows[:, 24] > 0)

    @property
    def aside_mps(self) -> Float64[Array, " n"]:
        """Across the heading, to the left: how contacts push it."""
        return self.rows[:, 25]

    def quaternion(self) -> Float64[Array, "n 4"]:
        """Attitudes of base_link: x, y, z, w."""
        return quaternion_from_rpy(self.rpy_rad)

    def position_m(self) -> Float64[Array, "n 3"]:
        """Positions of base_link, which stands upright on the wheels' plane."""
        pose = transform_from_xyz_quaternion(self.ground_m, self.quaternion())
        return np.asarray(self.ground_m + BASE_HEIGHT_M * pose[:, :3, 2])

    def rates_radps(self) -> Float64[Array, "n 3"]:
        """Turning rates of the body about its own axes."""
        roll, pitch, _ = self.rpy_rad.T
        _, rolling, pitching = self.bounce.T
        turn = self.turn_radps
        return np.stack(
            [
                rolling - turn * np.sin(pitch),
                pitching * np.cos(roll) + turn * np.cos(pitch) * np.sin(roll),
                turn * np.cos(pitch) * np.cos(roll) - pitching * np.sin(roll),
            ],
            axis=1,
        )

    def velocity_mps(self) -> Float64[Array, "n 3"]:
        """Velocities of base_link, world axes."""
        yaw = self.rpy_rad[:, 2]
        rotation = transform_from_xyz_quaternion(self.ground_m, self.quaternion())[:, :3, :3]
        up = np.array([0.0, 0.0, BASE_HEIGHT_M])
        lever = np.einsum("nij,nj->ni", rotation, np.cross(self.rates_radps(), up))
        cos, sin, ahead, aside = np.cos(yaw), np.sin(yaw), self.speed_mps * np.cos(self.rpy_rad[:, 1]), self.aside_mps
        level = np.stack([ahead * cos - aside * sin, ahead * sin + aside * cos, self.bounce[:, 0]], axis=1)
        return np.asarray(level + lever)

    def body_velocity_mps(self) -> Float64[Array, "n 3"]:
        """Velocities of base_link, in the body's axes."""
        rotation = transform_from_xyz_quaternion(self.ground_m, self.quaternion())[:, :3, :3]
        return np.asarray(np.einsum("nji,nj->ni", rotation, self.velocity_mps()))
