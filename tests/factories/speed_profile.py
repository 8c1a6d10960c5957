"""A second method along a recording, as small as one can be: how fast the robot went, by its odometry."""

from collections.abc import Mapping
from typing import ClassVar, NamedTuple

from navtool.base.note import Note
from navtool.methods.along.observation import Observation, Skip
from navtool.methods.along.odometry import Odometry, OdometryReading
from navtool.methods.along.table_method import TableMethod


class Speeds(NamedTuple):
    """Speeds of the base."""

    forward_mps: float
    turning_radps: float


class SpeedProfile(TableMethod[OdometryReading, Speeds]):
    """Speeds up to a limit; what is faster is skipped."""

    kind: ClassVar[str] = "a speed profile"
    title: ClassVar[str] = "Speeds"
    columns: ClassVar[tuple[str, ...]] = Speeds._fields

    def __init__(self, most_mps: float = 10.0) -> None:
        self.ticks = Odometry()
        self._most_mps = most_mps
        self._forward_mps: list[float] = []

    @property
    def settings(self) -> Mapping[str, object]:
        """The limit."""
        return {"most_mps": self._most_mps}

    def step(self, observation: Observation[OdometryReading]) -> Speeds | Skip:
        """The speeds of a message."""
        forward_mps = float(observation.reading.linear_mps[0])
        if abs(forward_mps) > self._most_mps:
            return Skip(
                "faster than robots go",
                Note("speed.beyond-robots", f"odometry: {forward_mps:g} m/s at {observation.stamp_ns} ns"),
            )
        self._forward_mps.append(forward_mps)
        return Speeds(forward_mps, float(observation.reading.angular_radps[2]))

    def figures(self) -> dict[str, float]:
        """The fastest and the mean."""
        return {"most_mps": max(self._forward_mps), "mean_mps": sum(self._forward_mps) / len(self._forward_mps)}
