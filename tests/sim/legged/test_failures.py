import dataclasses
from collections.abc import Callable

import numpy as np
import pytest
from legged_walk import walk_straight

from navtool.sim.drive.failure import Failure, FailureKind
from navtool.sim.legged.body import STEP_S
from navtool.sim.legged.failures import FailureLimits, find_failures
from navtool.sim.legged.footings import concrete, rocks
from navtool.sim.legged.gaits import GaitName
from navtool.sim.legged.obstacle import Form, Obstacle
from navtool.sim.legged.robot import LeggedRobot
from navtool.sim.legged.track import LeggedTrack, track_of


def of(failures: tuple[Failure, ...], kind: FailureKind) -> list[Failure]:
    return [failure for failure in failures if failure.kind is kind]


@pytest.mark.parametrize("gait", list(GaitName))
def test_nothing_fails_on_level_hard_ground(gait: GaitName, on_concrete: Callable[[GaitName], LeggedTrack]) -> None:
    assert on_concrete(gait).failures == ()


def test_a_wall_is_hit_where_it_stands_and_then_it_is_stuck() -> None:
    wall = Obstacle(name="garden wall", form=Form.BOX, centre_m=(1.5, 0.0, 0.5), size_m=(0.1, 2.0, 0.5))
    track = walk_straight(LeggedRobot(concrete(), [wall]), 5.5, 0.5)
    hits, stuck = of(track.failures, FailureKind.collision), of(track.failures, FailureKind.stuck)
    assert hits[0].reason == "against garden wall"
    assert 0.6 < hits[0].x_m < 1.2
    assert stuck
    assert stuck[0].reason == "against garden wall"
    assert stuck[0].end_s - stuck[0].start_s >= 3.0


def test_a_thicket_entangles_it() -> None:
    thicket = dataclasses.replace(concrete(), drag_nspm2=1500.0, cover_m=0.7)
    track = walk_straight(LeggedRobot(thicket), 4.0, 0.4)
    assert of(track.failures, FailureKind.entangled)
    assert not of(track.failures, FailureKind.collision)


def test_a_cliff_makes_it_fall_for_the_rest_of_the_track() -> None:
    heights = concrete().heights_m.copy()
    heights[:, round(4.5 / 0.04) :] = -1.0
    robot = LeggedRobot(dataclasses.replace(concrete(), heights_m=heights))
    fell_s = float(walk_straight(robot, 20.0, 0.5).time_s[-1])
    robot.step(0.5, 0.0, 1.0)
    track = track_of(robot, seed=1)
    (fall,) = of(track.failures, FailureKind.fall)
    assert 0.9 < fall.x_m < 2.2
    assert fall.start_s == pytest.approx(fell_s, abs=0.01)
    assert fall.end_s == pytest.approx(track.time_s[-1] + STEP_S)


def test_feet_that_slide_are_stumbles(on_concrete: Callable[[GaitName], LeggedTrack]) -> None:
    limits = FailureLimits(slip_m=0.03)
    ice = dataclasses.replace(concrete(), friction=0.22)
    slid = walk_straight(LeggedRobot(ice), 3.0, 0.5)
    stumbles = of(find_failures(slid.truth, limits=limits), FailureKind.stumble)
    assert any("foot slid" in failure.reason for failure in stumbles)
    assert find_failures(on_concrete(GaitName.TROT).truth, limits=limits) == ()


def test_stones_make_it_stumble_and_every_failure_has_its_time_and_place() -> None:
    track = walk_straight(LeggedRobot(rocks(1)), 5.0, 0.5)
    stumbles = of(track.failures, FailureKind.stumble)
    assert stumbles
    starts = [failure.start_s for failure in track.failures]
    assert starts == sorted(starts)
    for failure in track.failures:
        assert failure.start_s < failure.end_s <= track.time_s[-1] + STEP_S
        place = track.truth.position_m[round(failure.start_s / STEP_S)]
        assert (failure.x_m, failure.y_m) == (place[0], place[1])


def test_a_push_that_throws_the_body_about_is_a_stumble(on_concrete: Callable[[GaitName], LeggedTrack]) -> None:
    truth = on_concrete(GaitName.TROT).truth
    quaternion = truth.quaternion.copy()
    quaternion[1500:1600] = [np.sin(0.25), 0.0, 0.0, np.cos(0.25)]
    (failure,) = find_failures(dataclasses.replace(truth, quaternion=quaternion))
    assert failure.kind is FailureKind.stumble
    assert failure.reason == "the body was thrown about"
    assert failure.start_s == pytest.approx(3.0, abs=0.01)
    assert 3.2 <= failure.end_s < 3.6, "the feet were dragged along"
