"""Settings of what walks along a recording or an episode."""

import math
from dataclasses import dataclass, field

from navtool.base.setting_checks import fault, outside
from navtool.base.setting_error import refuse


@dataclass(kw_only=True, slots=True)
class GoalConfig:
    """Where the robot is taken to be going: obstacles grow away from there."""

    ahead_m: float = 5.0
    """The goal is where the robot itself drove so far away later, 0.5 to 100 m."""
    odom_m: list[float] = field(default_factory=list)
    """A fixed goal instead, x and y in the odometry frame in metres; empty for none."""

    def __post_init__(self) -> None:
        whole = len(self.odom_m) in (0, 2) and all(map(math.isfinite, self.odom_m))
        refuse(
            outside(self, 0.5, 100, "ahead_m", unit="m"),
            fault(
                "odom_m",
                f"{self.odom_m} is not a place of finite numbers",
                "give [x, y] in metres, or [] for where the robot drove",
                when=not whole,
            ),
        )
