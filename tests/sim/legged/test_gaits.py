import dataclasses
import itertools
from collections.abc import Callable

import numpy as np
import pytest

from navtool.sim.errors import SimError
from navtool.sim.legged.body import STEP_S
from navtool.sim.legged.gaits import GAITS, GaitName
from navtool.sim.legged.track import LeggedTrack

EVERY_GAIT = pytest.mark.parametrize("gait", list(GaitName))


@EVERY_GAIT
def test_feet_stand_as_long_as_the_table_says(gait: GaitName, on_concrete: Callable[[GaitName], LeggedTrack]) -> None:
    touching = on_concrete(gait).truth.foot_force_n[1000:] > 5.0
    strides = round(GAITS[gait].period_s / STEP_S)
    whole = touching[: len(touching) // strides * strides]
    assert whole.mean(axis=0) == pytest.approx(np.full(4, GAITS[gait].duty), abs=0.06)


@EVERY_GAIT
def test_as_many_feet_stand_as_the_gait_is_known_for(
    gait: GaitName, on_concrete: Callable[[GaitName], LeggedTrack]
) -> None:
    standing = (on_concrete(gait).truth.foot_force_n[1000:] > 5.0).sum(axis=1)
    if gait is GaitName.TROT:
        assert np.median(standing) == 2
    elif gait is GaitName.CRAWL:
        assert np.percentile(standing, 2) >= 3
    else:
        assert (standing >= 2).mean() > 0.97
        assert 2.5 < standing.mean() < 3.2


def test_the_crawls_feet_come_down_hind_before_front_of_the_same_side(
    on_concrete: Callable[[GaitName], LeggedTrack],
) -> None:
    standing = on_concrete(GaitName.CRAWL).truth.standing
    down = np.argwhere(np.diff(standing.astype(int), axis=0) > 0)
    order = [leg for _, leg in down.tolist()][4:12]
    following = {2: 0, 0: 3, 3: 1, 1: 2}
    assert all(following[first] == then for first, then in itertools.pairwise(order))


@EVERY_GAIT
def test_the_sways_speed_and_acceleration_are_its_derivatives(gait: GaitName) -> None:
    phase = np.linspace(0.0, 1.0, 2001)
    place, speed, acceleration = np.array([GAITS[gait].sway(value) for value in phase.tolist()]).T
    time_s = phase * GAITS[gait].period_s
    assert speed == pytest.approx(np.gradient(place, time_s), abs=2e-3)
    assert acceleration == pytest.approx(np.gradient(speed, time_s), abs=2e-2)
    assert np.abs(place).max() == pytest.approx(GAITS[gait].sway_m, abs=1e-4)


def test_the_body_leans_away_from_a_stepping_foot() -> None:
    crawl = GAITS[GaitName.CRAWL]
    for offset, side in zip(crawl.offsets, (1, -1, 1, -1), strict=True):
        assert side * crawl.sway(offset - 0.5 * (1 - crawl.duty))[0] < 0


def test_a_gait_without_period_is_refused() -> None:
    with pytest.raises(SimError, match="duty factor of 1"):
        dataclasses.replace(GAITS[GaitName.TROT], duty=1.0)
