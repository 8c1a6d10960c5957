import dataclasses

import numpy as np
import pytest

from navtool.sim.errors import SimError
from navtool.sim.robot import STEP_S, RobotLimits
from navtool.sim.scene import Scene
from navtool.sim.track import Track, drive


@pytest.fixture(scope="module")
def tracks(place: Scene) -> list[Track]:
    return [drive(place, seed, 22.0, mischief=0.7) for seed in range(6)]


def steps(start_s: float, end_s: float) -> slice:
    return slice(round(start_s / STEP_S), round(end_s / STEP_S))


def test_a_drive_stays_within_physics(tracks: list[Track]) -> None:
    limits = RobotLimits()
    for track in tracks:
        assert np.abs(track.speed_mps).max() <= limits.max_speed_mps
        assert np.abs(track.turn_radps).max() <= limits.max_turn_radps
        moved = np.hypot(np.diff(track.x_m), np.diff(track.y_m))
        assert moved == pytest.approx(np.abs(track.speed_mps[1:]) * STEP_S, abs=1e-9), "it never jumps"
        assert np.diff(track.yaw_rad) == pytest.approx(track.turn_radps[1:] * STEP_S, abs=1e-9)
        slip = np.cos(track.yaw_rad[:-1]) * np.diff(track.y_m) - np.sin(track.yaw_rad[:-1]) * np.diff(track.x_m)
        assert np.abs(slip).max() < 1e-4, "nor slides sideways"
        assert np.hypot(track.roll_rad, track.pitch_rad).max() < 0.12


def test_a_robot_never_enters_a_solid_body(place: Scene, tracks: list[Track]) -> None:
    for track in tracks:
        xy = np.stack([track.x_m, track.y_m])
        for thing in place.obstacles():
            if thing.material.solid:
                assert thing.shape.clearance(xy).min() > RobotLimits().radius_m - 0.05


def test_a_collision_is_a_sudden_stop_under_a_command(tracks: list[Track]) -> None:
    failures = [(track, event) for track in tracks for event in track.failures if event.reason == "collision"]
    assert len(failures) >= 3
    for track, event in failures:
        start = round(event.start_s / STEP_S)
        braking = -np.diff(np.abs(track.speed_mps[start - 2 : start + 8])).min() / STEP_S
        assert braking > 10, "harder than any brake"
        pushing = steps(event.start_s + 0.1, min(event.start_s + 0.9, event.end_s))
        assert np.abs(track.speed_mps[pushing]).max() < 0.05
        assert np.abs(track.command_mps[pushing]).max() > 0.05


def test_stuck_is_a_command_without_motion_until_the_operator_intervenes(tracks: list[Track]) -> None:
    failures = [(track, event) for track in tracks for event in track.failures if event.reason == "stuck"]
    assert len(failures) >= 3
    for track, event in failures:
        held = steps(event.start_s, min(event.start_s + 2.4, event.end_s))
        assert np.abs(track.speed_mps[held]).max() < 0.08
        assert track.command_mps[held].min() > 0.1
        assert not track.intervention[held].any()
        if event.end_s < track.time_s[-1]:
            assert track.intervention[steps(event.end_s - 0.5, event.end_s)].all(), "it ends with the rescue"


def test_the_operator_intervenes_in_failures_only(tracks: list[Track]) -> None:
    for track in tracks:
        failing = np.zeros(track.time_s.size, bool)
        for event in track.failures:
            failing[steps(event.start_s, event.end_s)] = True
        assert not (track.intervention & ~failing).any()
        assert not (track.contact & ~failing).any()


def test_a_careful_driver_fails_less(place: Scene, tracks: list[Track]) -> None:
    careful = [drive(place, seed, 22.0, mischief=0.0).failed_share for seed in range(3)]
    assert np.mean(careful) < 0.5 * np.mean([track.failed_share for track in tracks])


def test_equal_seeds_give_equal_tracks(place: Scene, tracks: list[Track]) -> None:
    again, other = drive(place, 3, 22.0, mischief=0.7), tracks[4]
    for field in dataclasses.fields(Track):
        assert np.array_equal(getattr(again, field.name), getattr(tracks[3], field.name))
    assert (again.x_m != other.x_m).any()


def test_poses_interpolate_between_steps(tracks: list[Track]) -> None:
    track = tracks[0]
    poses = track.pose(np.array([3.0, 3.005, 3.01]))
    assert poses[0, :2, 3] == pytest.approx([track.x_m[300], track.y_m[300]], abs=1e-9)
    assert poses[1, :3, 3] == pytest.approx((poses[0, :3, 3] + poses[2, :3, 3]) / 2, abs=1e-9)


@pytest.mark.parametrize(
    ("seed", "seconds", "mischief"), [(-1, 9.0, 0.5), (0, 0.5, 0.5), (0, float("nan"), 0.5), (0, 9.0, 1.1)]
)
def test_a_drive_out_of_bounds_is_refused(place: Scene, seed: int, seconds: float, mischief: float) -> None:
    with pytest.raises(SimError, match="a drive needs"):
        drive(place, seed, seconds, mischief)
