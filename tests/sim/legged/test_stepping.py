import pytest

from navtool.base.setting_error import SettingError
from navtool.sim.legged.controller_config import CONTROL_S, ControllerConfig
from navtool.sim.legged.gaits import GAITS, GaitName
from navtool.sim.legged.stepping import LegMode, Stepping

FEET = [[0.3, 0.17, 0.0], [0.3, -0.17, 0.0], [-0.3, 0.17, 0.0], [-0.3, -0.17, 0.0]]


def stepping(gait: GaitName = GaitName.CRAWL) -> Stepping:
    return Stepping(GAITS[gait], ControllerConfig())


def until_swing(legs: Stepping, leg: int) -> None:
    while legs.modes[leg] is not LegMode.SWING:
        legs.advance(FEET, [mode is not LegMode.SWING for mode in legs.modes], wanted=True)


def test_feet_rest_until_there_is_a_reason_to_walk() -> None:
    legs = stepping()
    for _ in range(500):
        legs.advance(FEET, [True] * 4, wanted=False)
    assert legs.modes == [LegMode.STANCE] * 4
    assert legs.phase == 0.0


@pytest.mark.parametrize("gait", list(GaitName))
def test_steps_follow_the_table_when_the_ground_is_where_it_should_be(gait: GaitName) -> None:
    legs = stepping(gait)
    in_the_air = [0] * 4
    ticks = round(10 * GAITS[gait].period_s / CONTROL_S)
    for _ in range(ticks):
        legs.advance(FEET, [legs.share(leg) is None for leg in range(4)], wanted=True)
        for leg, mode in enumerate(legs.modes):
            in_the_air[leg] += mode is not LegMode.STANCE
    assert [count / ticks for count in in_the_air] == pytest.approx([1 - GAITS[gait].duty] * 4, abs=0.02)


def test_a_foot_that_meets_the_ground_early_stands_until_its_next_turn() -> None:
    legs = stepping()
    until_swing(legs, 0)
    while (legs.share(0) or 0.0) < 0.7:
        legs.advance(FEET, [False, True, True, True], wanted=True)
    legs.advance(FEET, [True] * 4, wanted=True)
    assert legs.modes[0] is LegMode.STANCE
    while legs.share(0) is not None:
        legs.advance(FEET, [True] * 4, wanted=True)
        assert legs.modes[0] is LegMode.STANCE
    assert legs.stumbles == 0


def test_a_foot_that_does_not_find_the_ground_reaches_for_it() -> None:
    legs = stepping()
    until_swing(legs, 0)
    for _ in range(round(0.6 / CONTROL_S)):
        legs.advance(FEET, [False, True, True, True], wanted=True)
    x, y, z = FEET[0]
    assert legs.modes == [LegMode.REACH, *[LegMode.STANCE] * 3]
    assert legs.reach[0][:2] == (x, y)
    assert legs.reach[0][2] < z - 0.05
    assert legs.trust()[0] == 0.0
    legs.advance(FEET, [True] * 4, wanted=True)
    assert legs.modes == [LegMode.STANCE] * 4


def test_a_foot_that_is_caught_is_lifted_and_counted_once_a_step() -> None:
    legs = stepping()
    until_swing(legs, 0)
    height = legs.swings[0].height_m
    while (legs.share(0) or 0.0) < 0.5:
        legs.advance(FEET, [True] * 4, wanted=True)
    assert legs.stumbles == 1
    assert height < legs.swings[0].height_m <= height + 0.14 + 1e-12
    assert legs.modes[0] is LegMode.SWING


def test_after_a_foot_was_caught_all_feet_are_lifted_higher_for_a_while() -> None:
    legs = stepping()
    until_swing(legs, 0)
    while (legs.share(0) or 0.0) < 0.5:
        legs.advance(FEET, [True] * 4, wanted=True)
    heights = []
    for _ in range(20):
        for leg in (3, 1, 2, 0):
            while legs.modes[leg] is LegMode.SWING:
                legs.advance(FEET, [legs.share(foot) is None for foot in range(4)], wanted=True)
            until_swing(legs, leg)
            heights.append(legs.swings[leg].height_m)
    usual = GAITS[GaitName.CRAWL].step_height_m
    assert heights[0] > usual + 0.03
    assert heights[-1] == pytest.approx(usual, abs=0.002)
    assert heights == sorted(heights, reverse=True)


def test_it_stops_once_all_feet_stand() -> None:
    legs = stepping(GaitName.TROT)
    until_swing(legs, 1)
    for _ in range(round(1.0 / CONTROL_S)):
        legs.advance(FEET, [legs.share(leg) is None for leg in range(4)], wanted=False)
    assert not legs.walking
    assert legs.modes == [LegMode.STANCE] * 4
    assert legs.trust() == [1.0] * 4


def test_the_controllers_settings_have_bounds() -> None:
    with pytest.raises(SettingError, match="height"):
        ControllerConfig(height_m=0.9)
    with pytest.raises(SettingError, match="touch_n"):
        ControllerConfig(touch_n=0.0)
