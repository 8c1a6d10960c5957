"""Failures begin when, where and why they happen, and never without a reason."""

from collections.abc import Callable

import numpy as np
import pytest

from navtool.base.setting_error import SettingError
from navtool.sim.drive.drive import Drive
from navtool.sim.drive.failure import Failure, FailureKind
from navtool.sim.wheeled.config import STEP_S, WheeledConfig
from navtool.sim.wheeled.failures import FailureLimits
from navtool.sim.wheeled.robot import WheeledRobot
from navtool.sim.world.obstacle import Obstacle
from navtool.sim.world.place import World, make_world
from navtool.sim.world.scenario import ScenarioConfig
from navtool.sim.world.surfaces import surface_number

Place = Callable[..., World]
Run = Callable[..., WheeledRobot]
WALL_M = 2.0
WALL = Obstacle(
    kind="wall",
    surface=surface_number("brick"),
    x_m=WALL_M + 0.1,
    y_m=0.0,
    half_length_m=2.0,
    half_width_m=0.1,
    yaw_rad=np.pi / 2,
    height_m=2.0,
)


def of(drive: Drive, kind: FailureKind) -> list[Failure]:
    return [failure for failure in drive.failures if failure.kind is kind]


def test_a_plain_drive_has_no_failures(place: Place, run: Run) -> None:
    for surface in ("concrete", "gravel", "grass", "sand"):
        drive = run(place(surface), (5.0, 0.9, 0.1), (1.0, 0.0, 0.0), (2.0, -0.3, 0.4), (2.0, 0.0, 0.8)).drive(1)
        assert drive.failures == (), surface
        assert drive.failed_share == 0.0


def test_a_wall_is_hit_when_and_where_it_stands_until_it_backs_off(place: Place, run: Run) -> None:
    robot = run(place(things=[WALL]), (5.0, 0.6, 0.0), (3.0, -0.4, 0.0))
    drive = robot.drive(1)
    (hit,) = of(drive, FailureKind.collision)
    reached = WALL_M - WheeledConfig().half_length_m
    assert hit.x_m == pytest.approx(reached, abs=0.02)
    assert hit.y_m == pytest.approx(0.0, abs=0.01)
    assert hit.reason == "against wall"
    gap = WALL_M - (robot.samples().ground_m[:, 0] + robot.config.half_length_m)
    arrives = float(drive.time_s[np.argmax(gap < 0.01)])
    assert hit.start_s == pytest.approx(arrives, abs=0.03)
    assert 5.0 < hit.end_s < 5.5
    (stuck,) = of(drive, FailureKind.stuck)
    assert stuck.reason == "against wall"
    assert hit.start_s <= stuck.start_s < hit.start_s + 0.5
    assert 5.0 <= stuck.end_s < 5.5
    assert drive.failed_share == pytest.approx((hit.end_s - hit.start_s) / 8.0, abs=0.02)


def test_it_is_never_stuck_when_nothing_is_asked_for(place: Place, run: Run) -> None:
    for world in (place(), place("mud"), place(things=[WALL])):
        drive = run(world, (6.0, 0.0, 0.0), start=(1.4, 0.0, 0.0)).drive(1)
        assert drive.failures == ()
    drive = run(place(things=[WALL]), (3.4, 0.6, 0.0), (8.0, 0.0, 0.0)).drive(1)
    assert not of(drive, FailureKind.stuck)
    asked = np.abs(drive.command).max(axis=1) > 0
    for failure in of(run(place(things=[WALL]), (6.0, 0.6, 0.0), (5.0, 0.0, 0.0)).drive(1), FailureKind.stuck):
        assert failure.end_s <= asked.size * STEP_S
        assert failure.end_s <= 6.1


def test_mud_entangles_uphill_and_not_on_the_level(place: Place, run: Run) -> None:
    assert run(place("mud"), (8.0, 0.6, 0.0), start=(-3.0, 0.0, 0.0)).drive(1).failures == ()
    uphill = place("mud", lambda x, _: 0.12 * np.clip(x, 0.0, 8.0))
    (held,) = run(uphill, (8.0, 0.6, 0.0), start=(-2.0, 0.0, 0.0)).drive(1).failures
    assert held.kind is FailureKind.entangled
    assert held.reason == "held by mud"
    assert -0.5 < held.x_m < 1.0
    freed = run(uphill, (8.0, 0.6, 0.0), start=(-2.0, 0.0, 0.0))
    freed.step(-0.4, 0.0, 3.0, freed=True)
    drive = freed.drive(1)
    assert of(drive, FailureKind.entangled)[0].end_s < 8.7
    assert drive.intervention[-1]


def test_a_slope_beyond_the_drives_is_stuck_without_being_held(place: Place, run: Run) -> None:
    steep = place("concrete", lambda x, _: 0.7 * np.clip(x, 0.0, 4.0))
    failures = run(steep, (6.0, 0.6, 0.0), start=(-1.0, 0.0, 0.0)).drive(1).failures
    assert FailureKind.stuck in {failure.kind for failure in failures}
    assert any(failure.reason == "the drives cannot climb the concrete" for failure in failures)


def test_a_rock_bed_throws_it_about_and_grass_does_not(run: Run) -> None:
    def stumbles(ground: str, speed: float) -> list[Failure]:
        found = []
        for seed in (7, 8, 9):
            world = make_world(ScenarioConfig(name="open", side_m=30.0, course_m=20.0, ground=ground), seed)
            found += of(run(world, (18.0, speed, 0.0), start=(-10.0, 0.0, 0.0)).drive(1), FailureKind.stumble)
        return found

    thrown = stumbles("rock_bed", 1.0)
    assert thrown
    assert all(failure.reason.endswith("rock bed") for failure in thrown)
    assert not stumbles("grass", 1.0)


def test_a_cliff_is_a_fall_until_the_end(place: Place, run: Run) -> None:
    drive = run(place("concrete", lambda x, _: np.where(x > 2.0, -1.5, 0.0)), (6.0, 0.8, 0.0)).drive(1)
    (fall,) = of(drive, FailureKind.fall)
    assert fall.reason == "it tipped over lengthwise"
    assert fall.end_s == drive.duration_s
    assert 1.2 < fall.x_m < 2.5


def test_failures_come_in_order_and_within_the_drive(place: Place, run: Run) -> None:
    orders = [(2.5, 0.8, 0.0), (1.5, -0.5, 0.3), (3.0, 0.7, 0.0), (2.0, -0.5, 0.0)]
    drive = run(place(things=[WALL]), *orders).drive(1)
    assert len(of(drive, FailureKind.collision)) == 2
    starts = [failure.start_s for failure in drive.failures]
    assert starts == sorted(starts)
    for failure in drive.failures:
        assert 0 <= failure.start_s < failure.end_s <= drive.duration_s


def test_limits_are_checked() -> None:
    with pytest.raises(SettingError, match="stuck_s"):
        FailureLimits(stuck_s=0.0)
