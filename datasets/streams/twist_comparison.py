"""Recorded velocities beside what the poses and other sensors say, as they are mended step by step."""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Bool, Float64

from navtool.base.note import Note
from navtool.datasets.streams.pose_travel import PoseTravel
from navtool.datasets.streams.twist_windows import Windows, summed
from navtool.pipeline.arrays import Array

APART = "odometry.twist-apart"
"""Code of the notes that say that speeds and poses disagree, and that nothing was done."""

LEAST_TRAVEL = np.array([0.5, 0.5, 0.3])
"""Travel by the poses from which a part that stays zero was never filled: metres, metres, radians."""
FASTEST_MPS = 30.0
"""Poses that are faster are in another unit themselves."""
_LEAST_WINDOWS = 2.0
"""What is compared has to move for so many windows on end."""


@dataclass(frozen=True, slots=True)
class Witnesses:
    """Other sensors' words on which way a robot moves, at the poses of a travel; None where there is none.

    Attributes:
        command_mps: The forward speed that was asked for.
        gyro_radps: The turning rate that the IMU measured.
    """

    command_mps: Float64[Array, " n"] | None = None
    gyro_radps: Float64[Array, " n"] | None = None


@dataclass(slots=True)
class TwistComparison:
    """Velocities that are mended column by column.

    Attributes:
        speeds: Forward, left, turning rate at each pose of the travel.
        travel: What the poses say.
        witnesses: What other sensors say.
        found: The windows in which both are compared.
        notes: What was seen and done, and what could not be decided.
        taken: Which columns are the poses' own now.
        undecided: Which columns disagree with the poses in a way that nothing decides, or where the poses are wrong.
    """

    speeds: Float64[Array, "n 3"]
    travel: PoseTravel
    witnesses: Witnesses
    found: Windows
    notes: list[Note] = field(default_factory=list)
    taken: Bool[Array, " 3"] = field(default_factory=lambda: np.zeros(3, dtype=np.bool_))
    undecided: Bool[Array, " 3"] = field(default_factory=lambda: np.zeros(3, dtype=np.bool_))

    @property
    def by_poses(self) -> Float64[Array, "windows 3"]:
        """Travel within each window by the poses."""
        return self.found.over(self.travel.travel)

    @property
    def by_twist(self) -> Float64[Array, "windows 3"]:
        """Travel within each window by the velocities."""
        return self.found.over(summed(self.speeds, self.travel.time_s))

    def travelled(self) -> Float64[Array, " 3"]:
        """Travel by the poses of all windows that move, whatever its sign."""
        moved = np.where(self.found.moving(self.by_poses), np.abs(self.by_poses), 0.0)
        # Windows overlap: one begins with each pose.
        return np.asarray(moved.sum(axis=0) * self.travel.period_s / self.found.length_s.mean())

    @property
    def least_m(self) -> Float64[Array, " windows"]:
        """What counts as motion within each window, in metres."""
        return self.found.least()[:, 0]

    def last_enough(self, moves: Bool[Array, " windows"], found: Windows | None = None) -> bool:
        """Whether windows in which something moves are enough to judge by.

        Args:
            found: The windows, where they are others than those of the comparison.
        """
        length_s = (found or self.found).length_s
        return bool(length_s.size) and bool(moves.sum() * self.travel.period_s >= _LEAST_WINDOWS * length_s.mean())

    def leave(self, columns: list[int], what: str) -> None:
        """Keep columns as they were recorded, with a note that nothing decides."""
        self.undecided[columns] = True
        cure = "kept as recorded; robot.odometry_twist=from_poses takes the speeds from the poses"
        self.notes.append(Note(APART, f"odometry: {what}; {cure}"))
