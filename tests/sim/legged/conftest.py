"""Drives of the quadruped that several tests look at; each is driven once."""

from collections.abc import Callable
from functools import cache

import pytest
from legged_walk import walk_straight

from navtool.sim.legged.footing import Footing
from navtool.sim.legged.footings import concrete
from navtool.sim.legged.gaits import GaitName
from navtool.sim.legged.robot import LeggedRobot
from navtool.sim.legged.track import LeggedTrack

CRUISE_MPS = {GaitName.TROT: 0.5, GaitName.CRAWL: 0.3, GaitName.AMBLE: 0.5}


@pytest.fixture(scope="session")
def drive() -> Callable[..., LeggedTrack]:
    """Drive straight on a ground for a time at a speed."""

    def go(footing: Footing, gait: GaitName, seconds: float, speed_mps: float | None = None) -> LeggedTrack:
        speed = CRUISE_MPS[gait] if speed_mps is None else speed_mps
        return walk_straight(LeggedRobot(footing, gait=gait), seconds, speed)

    return go


@pytest.fixture(scope="session")
def on_concrete(drive: Callable[..., LeggedTrack]) -> Callable[[GaitName], LeggedTrack]:
    """Five seconds on level hard ground."""

    @cache
    def go(gait: GaitName) -> LeggedTrack:
        return drive(concrete(), gait, 5.0)

    return go
