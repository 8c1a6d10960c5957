"""Walks over every surface of the simulated places in every gait, and what they feel like."""

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest

from navtool.sim.drive.drive import Drive
from navtool.sim.drive.failure import FailureKind
from navtool.sim.legged.gaits import GaitName
from navtool.sim.legged.vehicle import LeggedVehicle
from navtool.sim.legged.vibration import vibration_rms
from navtool.sim.world.place import make_world
from navtool.sim.world.scenario import Scatter, ScenarioConfig

EVERY_GAIT = pytest.mark.parametrize("gait", list(GaitName))
SURFACES = ("concrete", "asphalt", "sand", "gravel", "mulch", "grass", "tall_grass", "mud", "rock_bed")
STABLE = ("concrete", "asphalt")
MAY_FALL = ("mud", "rock_bed")
"""Where a gait may fall; nowhere else."""
EQUAL_MPS = 0.3
CRUISE_MPS = {GaitName.TROT: 0.6, GaitName.CRAWL: 0.3, GaitName.AMBLE: 0.6}
SEEDS = (21, 22, 23)
START_M = -6.0
PATIENCE = 4.0
"""It is given so many times as long as its speed asks for: dense stems hold it now and then."""
FAR = ("concrete",)
"""Where it walks 20 m; elsewhere 3 m."""

Walk = Callable[[str, GaitName, int, float, float], Drive]


@pytest.fixture(scope="module")
def walk() -> Walk:
    """Walk so many metres over a place that is all of one surface, kept on the line as by a driver.

    Tall grass grows on turf, in patches that leave little free.
    """

    @cache
    def go(surface: str, gait: GaitName, seed: int, metres: float, speed_mps: float) -> Drive:
        ground, patches = ("grass", 120) if surface == "tall_grass" else (surface, 0)
        grass = Scatter(count=patches, gap_m=-1.0, size=[0.5, 1.0])
        config = ScenarioConfig(
            name=surface, ground=ground, side_m=36.0, course_m=24.0, hills_m=0.0, grass_patches=grass
        )
        vehicle = LeggedVehicle(make_world(config, seed), gait)
        state = vehicle.reset(START_M, 0.0, 0.0)
        while state.x_m < metres + START_M and not state.fallen and state.time_s < PATIENCE * metres / speed_mps:
            turn = min(max(-0.5 * state.y_m - state.yaw_rad, -0.4), 0.4)
            state = vehicle.step(speed_mps, turn, 0.2)
        return vehicle.drive(1)

    return go


def falls(drive: Drive) -> list[str]:
    return [failure.reason for failure in drive.failures if failure.kind is FailureKind.fall]


def went_m(drive: Drive) -> float:
    return float(drive.position_m[-1, 0] - drive.position_m[0, 0])


def vibration(drive: Drive) -> float:
    return vibration_rms(drive.imu.values[250:, :3], 250)


def current_a(drive: Drive) -> float:
    return -float(drive.battery.values[20:, 0].mean())


@EVERY_GAIT
def test_it_walks_on_concrete_and_reaches_what_it_was_sent_to(walk: Walk, gait: GaitName) -> None:
    drive = walk("concrete", gait, 1, 3.0, CRUISE_MPS[gait])
    assert went_m(drive) >= 3.0
    assert drive.failures == ()


@pytest.mark.slow
@EVERY_GAIT
def test_gravel_costs_more_current_than_concrete_and_tall_grass_more_than_gravel(walk: Walk, gait: GaitName) -> None:
    drawn = [current_a(walk(surface, gait, 21, 3.0, EQUAL_MPS)) for surface in ("concrete", "gravel", "tall_grass")]
    assert drawn[0] < drawn[1] < drawn[2]


@pytest.mark.slow
@EVERY_GAIT
@pytest.mark.parametrize("surface", SURFACES)
def test_it_walks_far_on_every_surface(walk: Walk, surface: str, gait: GaitName) -> None:
    metres = 20.0 if surface in FAR else 3.0
    drive = walk(surface, gait, 1, metres, CRUISE_MPS[gait])
    if surface in STABLE:
        assert drive.failures == ()
    if surface in MAY_FALL:
        assert went_m(drive) >= metres or falls(drive), "it may fall there, but then it says so"
    else:
        assert not falls(drive)
        assert went_m(drive) >= metres


@pytest.mark.slow
@EVERY_GAIT
def test_worse_ground_shakes_it_more_and_costs_more_current_at_the_same_speed(walk: Walk, gait: GaitName) -> None:
    grounds = ("concrete", "gravel", "rock_bed")
    drives = [[walk(ground, gait, seed, 3.0, EQUAL_MPS) for seed in SEEDS] for ground in grounds]
    shaken = [np.mean([vibration(drive) for drive in same]) for same in drives]
    drawn = [np.mean([current_a(drive) for drive in same]) for same in drives]
    assert shaken[0] < shaken[1] < shaken[2]
    assert drawn[0] < drawn[1] < drawn[2]


@pytest.mark.slow
def test_the_trot_shakes_it_more_than_the_crawl(walk: Walk) -> None:
    trot, crawl = (
        np.mean([vibration(walk("rock_bed", gait, seed, 3.0, EQUAL_MPS)) for seed in SEEDS])
        for gait in (GaitName.TROT, GaitName.CRAWL)
    )
    assert trot > 1.2 * crawl
