import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from navtool.sim.legged import felt_grip
from navtool.sim.legged.controller_config import CONTROL_S
from navtool.sim.legged.felt_grip import FIRM, LEAST, SLIDES_MPS, FeltGrip
from navtool.sim.legged.footings import concrete
from navtool.sim.legged.gaits import GaitName
from navtool.sim.legged.robot import LeggedRobot
from navtool.sim.legged.samples import Samples

STANDING = [True] * 4
LOADED_N = [80.0] * 4


def slide(grip: FeltGrip, asked: float, seconds: float, speed_mps: float = 1.0) -> float:
    """Let one foot slide while that ratio is asked of it; return what is counted on then."""
    for _ in range(round(seconds / CONTROL_S)):
        grip.feel([speed_mps, 0.0, 0.0, 0.0], LOADED_N, [min(asked, grip.friction), 0.0, 0.0, 0.0], STANDING)
    return grip.friction


def test_it_falls_below_the_ratio_at_which_a_foot_slides_and_stops_where_no_foot_does() -> None:
    grip = FeltGrip()
    while slide(grip, FIRM, CONTROL_S) > 0.3:
        pass
    assert 0.25 < grip.friction <= 0.3, "the foot stands again as soon as less is asked than the ground holds"
    assert slide(FeltGrip(), 0.3, 0.3) < 0.3


def test_it_falls_fast_and_recovers_slowly() -> None:
    grip = FeltGrip()
    low = slide(grip, 0.3, 0.2)
    assert low < 0.31
    after = [slide(grip, 0.3, 0.2, speed_mps=0.0) for _ in range(200)]
    assert after[0] < low + 0.1 * (FIRM - low)
    assert (np.diff(after) > 0).all()
    assert after[-1] == pytest.approx(FIRM, abs=1e-3)


@given(
    st.lists(
        st.tuples(*(st.lists(st.floats(0, top), min_size=4, max_size=4) for top in (6.0, 500.0, FIRM))), max_size=200
    )
)
def test_it_stays_within_its_bounds(felt: list[tuple[list[float], ...]]) -> None:
    grip = FeltGrip()
    for speed, force, asked in felt:
        grip.feel(speed, force, asked, STANDING)
        assert LEAST <= grip.friction <= FIRM


@pytest.mark.parametrize(
    ("speed_mps", "force_n", "standing"),
    [(0.9 * SLIDES_MPS, LOADED_N, STANDING), (3.0, [5.0] * 4, STANDING), (3.0, LOADED_N, [False] * 4)],
)
def test_feet_that_roll_hang_or_step_tell_nothing(speed_mps: float, force_n: list[float], standing: list[bool]) -> None:
    grip = FeltGrip()
    for _ in range(500):
        grip.feel([speed_mps] * 4, force_n, [0.5] * 4, standing)
    assert grip.friction == FIRM


def test_a_knock_tells_nothing() -> None:
    grip = FeltGrip()
    for _ in range(200):
        slide(grip, 0.5, 0.02)
        slide(grip, 0.5, 0.02, speed_mps=0.0)
    assert grip.friction == FIRM


@pytest.mark.parametrize("gait", list(GaitName))
def test_on_firm_ground_it_changes_nothing_to_the_bit(gait: GaitName, monkeypatch: pytest.MonkeyPatch) -> None:
    feeling = LeggedRobot(concrete(), gait=gait)
    feeling.step(0.3, 0.2, 2.0)
    monkeypatch.setattr(felt_grip, "SLIDES_MPS", math.inf)
    numb = LeggedRobot(concrete(), gait=gait)
    numb.step(0.3, 0.2, 2.0)
    assert all(
        np.array_equal(getattr(feeling.samples(), field.name), getattr(numb.samples(), field.name))
        for field in dataclasses.fields(Samples)
    )


def test_on_slippery_ground_it_finds_less_and_forgets_it_with_a_reset() -> None:
    robot = LeggedRobot(dataclasses.replace(concrete(), friction=0.2))
    felt = []
    for _ in range(20):
        robot.step(0.5, 0.0, 0.1)
        felt.append(robot.felt_friction)
    assert felt[0] == FIRM
    assert min(felt) < 0.7 * FIRM
    robot.reset()
    assert robot.felt_friction == FIRM
