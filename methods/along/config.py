"""Settings of what walks along a recording or an episode."""

import math
from dataclasses import dataclass, field


@dataclass(kw_only=True, slots=True)
class GoalConfig:
    """Where the robot is taken to be going: obstacles grow away from there."""

    ahead_m: float = 5.0
    """The goal is where the robot itself drove so far away later, 0.5 to 100 m."""
    odom_m: list[float] = field(default_factory=list)
    """A fixed goal instead, x and y in the odometry frame in metres; empty for none."""

    def __post_init__(self) -> None:
        if not 0.5 <= self.ahead_m <= 100:
            raise ValueError(f"goal.ahead_m = {self.ahead_m} m is outside 0.5-100 m")
        if len(self.odom_m) not in (0, 2) or not all(math.isfinite(value) for value in self.odom_m):
            raise ValueError(f"goal.odom_m = {self.odom_m} has to be [x, y] in metres, or [] for where the robot drove")
