"""Recorded velocities against poses: what is sound stays to the bit, what is spoilt is mended and told."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from odometry_drives import (
    ANGULAR,
    COURSES,
    FORWARD,
    LINEAR,
    SLOW,
    TURN,
    held,
    into_parent,
    jumping,
    odometry_drive,
    scaled,
)
from scipy.spatial.transform import Rotation

from navtool.base.note import Note
from navtool.datasets.recording import open_recording
from navtool.datasets.robot.config import RobotConfig, TopicCandidates
from navtool.datasets.robot.odometry_twist import OdometryTwist
from navtool.datasets.robot.topic_map import resolve_topic_map
from navtool.datasets.streams.clocks import Clocks
from navtool.datasets.streams.config import SyncConfig
from navtool.datasets.streams.first_pass import first_pass
from navtool.datasets.streams.odometry_twist import SPEEDS, in_own_axes, with_sound_twist
from navtool.datasets.streams.timed_stream import TimedStream
from navtool.pipeline.arrays import Array

NOISY: dict[str, Any] = {"noise_m": 0.01, "noise_rad": 0.005, "noise_mps": 0.02}
MOVING = tuple(name for name in COURSES if name != "stand")
DRIVEN = tuple(name for name in MOVING if name not in ("rotation", "only-sideways"))


def compared(
    stream: TimedStream,
    wanted: OdometryTwist | None = None,
    *,
    command: TimedStream | None = None,
    imu: TimedStream | None = None,
) -> tuple[Array, list[Note]]:
    own = in_own_axes(stream, wanted)
    others = {"command": command, "imu": imu}
    found = with_sound_twist(own.stream, wanted, {name: other for name, other in others.items() if other is not None})
    return found.stream.columns(*SPEEDS), [*own.notes, *found.notes]


def codes(notes: list[Note]) -> list[str]:
    return [note.code for note in notes]


@pytest.mark.parametrize("course", COURSES)
@pytest.mark.parametrize(
    "how",
    [
        {},
        NOISY,
        {"hz": 1.0, "seconds": 120.0},
        {"hz": 100.0, "jitter_s": 0.003, "noise_m": 0.002, "noise_mps": 0.05},
        {"noise_m": 0.1, "noise_rad": 0.02},
    ],
    ids=["clean", "noisy", "1-hz", "jitter", "noisy-poses"],
)
def test_sound_velocities_stay_to_the_bit_and_nothing_is_said(course: str, how: dict[str, Any]) -> None:
    drive = odometry_drive(course, **how)
    drive.values[::3, 3:7] *= -1  # the same attitudes
    own = in_own_axes(drive.stream(), None)
    found = with_sound_twist(own.stream, None, {})
    assert (own.notes, found.notes) == ([], [])
    np.testing.assert_array_equal(found.stream.values, drive.values)


@pytest.mark.parametrize("how", [{}, NOISY, {"hz": 5.0}], ids=["clean", "noisy", "5-hz"])
@pytest.mark.parametrize("course", [name for name in DRIVEN if name != "straight"])
def test_velocities_in_the_parent_frame_are_turned(course: str, how: dict[str, Any]) -> None:
    sound = odometry_drive(course, **how)
    speeds, notes = compared(sound.spoilt(into_parent).stream())
    assert codes(notes) == ["odometry.parent-twist"]
    np.testing.assert_allclose(speeds, sound.stream().columns(*SPEEDS), atol=1e-9)


@pytest.mark.parametrize("how", [{}, NOISY | {"jitter_s": 0.005}], ids=["clean", "noisy"])
@pytest.mark.parametrize("course", SLOW)
def test_slow_robots_are_looked_at_as_well(course: str, how: dict[str, Any]) -> None:
    sound = odometry_drive(course, **how)
    expected = sound.stream().columns(*SPEEDS)
    speeds, notes = compared(sound.stream())
    assert notes == []
    np.testing.assert_array_equal(speeds, expected)
    for spoil, code in (
        (into_parent, "odometry.parent-twist"),
        (scaled(vx=3.6, vy=3.6), "odometry.twist-unit"),
        (scaled(wz=57.29578), "odometry.twist-unit"),
        (scaled(vx=-1, vy=-1), "odometry.twist-turned"),
    ):
        speeds, notes = compared(sound.spoilt(spoil).stream())
        assert codes(notes) == [code]
        np.testing.assert_allclose(speeds, expected, atol=0.01)
    speeds, notes = compared(sound.spoilt(scaled(vx=0, vy=0)).stream())
    assert codes(notes) == ["odometry.twist-part"]
    assert np.quantile(np.abs(speeds[:, 0] - sound.truth[:, 0]), 0.9) < 0.05


def test_one_late_turn_tells_the_frame_and_without_one_the_speeds_come_out_alike() -> None:
    drive = odometry_drive("one-turn", seconds=120.0, yaw_rad=0.0)
    speeds, notes = compared(drive.spoilt(into_parent).stream())
    assert codes(notes) == ["odometry.parent-twist"]
    np.testing.assert_allclose(speeds, drive.truth, atol=1e-3)
    straight = odometry_drive("straight", yaw_rad=np.pi / 2)
    speeds, notes = compared(straight.spoilt(into_parent).stream())
    assert codes(notes) == ["odometry.twist-turned"], "by one straight line a turn and a frame look alike"
    np.testing.assert_allclose(speeds, straight.truth, atol=1e-3)


def test_velocities_of_a_tilted_body_are_turned_in_three_dimensions() -> None:
    drive = odometry_drive("circle")
    slope = Rotation.from_euler("xyz", [0.1, -0.3, 0.0])
    tilted = drive.spoilt(lambda _, v: v.__setitem__(np.s_[:, 3:7], (Rotation.from_quat(v[:, 3:7]) * slope).as_quat()))
    parent = tilted.spoilt(into_parent)
    own = in_own_axes(parent.stream(), None)
    assert codes(own.notes) == ["odometry.parent-twist"]
    np.testing.assert_allclose(own.stream.values, tilted.values, atol=1e-9)


@pytest.mark.parametrize("how", [{}, NOISY], ids=["clean", "noisy"])
@pytest.mark.parametrize("course", ["mixed", "circle", "reverse", "back-and-forth", "sideways"])
@pytest.mark.parametrize(
    ("empty", "names"), [({"vx": 0, "vy": 0}, "vx and vy are 0"), ({"wz": 0}, "wz is 0")], ids=["linear", "angular"]
)
def test_parts_never_filled_come_from_the_poses(
    course: str, how: dict[str, Any], empty: dict[str, float], names: str
) -> None:
    drive = odometry_drive(course, **how)
    speeds, notes = compared(drive.spoilt(scaled(**empty)).stream())
    (note,) = notes
    assert note.code == "odometry.twist-part"
    assert names in note.text
    np.testing.assert_allclose(speeds, drive.truth, atol=0.13 if how else 0.02)


def test_a_sideways_part_that_is_never_filled_comes_from_the_poses() -> None:
    drive = odometry_drive("sideways")
    speeds, notes = compared(drive.spoilt(scaled(vy=0)).stream())
    assert codes(notes) == ["odometry.twist-part"]
    np.testing.assert_allclose(speeds, drive.truth, atol=0.01)


@pytest.mark.parametrize("how", [{}, NOISY], ids=["clean", "noisy"])
def test_a_sideways_part_that_only_a_stretch_needs_comes_from_the_poses(how: dict[str, Any]) -> None:
    drive = odometry_drive("once-aside", **how)
    speeds, notes = compared(drive.spoilt(scaled(vy=0)).stream())
    assert codes(notes) == ["odometry.twist-part"]
    assert np.quantile(np.abs(speeds[:, 1] - drive.truth[:, 1]), 0.95) < 0.05


def test_no_velocity_at_all_and_parts_that_are_not_a_number_come_from_the_poses() -> None:
    drive = odometry_drive("mixed")
    speeds, notes = compared(drive.spoilt(scaled(vx=0, vy=0, wz=0)).stream())
    assert codes(notes) == ["state.no-twist"]
    np.testing.assert_allclose(speeds, drive.truth, atol=0.01)
    speeds, notes = compared(drive.spoilt(scaled(wz=np.nan)).stream())
    assert codes(notes) == ["odometry.twist-part"]
    np.testing.assert_allclose(speeds, drive.truth, atol=0.01)


@pytest.mark.parametrize("course", ["mixed", "circle", "lap", "reverse", "sideways"])
@pytest.mark.parametrize("how", [{}, NOISY], ids=["clean", "noisy"])
@pytest.mark.parametrize(
    ("factors", "unit"),
    [
        ({"wz": 57.2958}, "in deg/s"),
        ({"wz": -57.2958}, "in deg/s"),
        ({"vx": 3.6, "vy": 3.6}, "in km/h"),
        ({"vx": 1000.0, "vy": 1000.0}, "in mm/s"),
        ({"vx": 137.0, "vy": 137.0}, "in a unit of its own"),
    ],
    ids=["deg", "deg-reversed", "kmh", "mm", "ticks"],
)
def test_other_units_are_converted(course: str, how: dict[str, Any], factors: dict[str, float], unit: str) -> None:
    sound = odometry_drive(course, **how)
    speeds, notes = compared(sound.spoilt(scaled(**factors)).stream(), imu=sound.stream())
    assert any(note.code == "odometry.twist-unit" and unit in note.text for note in notes)
    np.testing.assert_allclose(speeds, sound.stream().columns(*SPEEDS), atol=0.01)


def test_a_factor_that_could_be_slip_is_told_and_left() -> None:
    drive = odometry_drive("mixed").spoilt(scaled(vx=1.5))
    speeds, notes = compared(drive.stream())
    assert codes(notes) == ["odometry.twist-apart"]
    assert "1.50 times as large" in notes[0].text
    np.testing.assert_array_equal(speeds, drive.stream().columns(*SPEEDS))


def test_poses_in_another_unit_leave_the_velocities_alone() -> None:
    drive = odometry_drive("mixed").spoilt(lambda _, values: values.__setitem__(np.s_[:, :2], values[:, :2] * 1000))
    speeds, notes = compared(drive.stream())
    assert codes(notes) == ["odometry.twist-apart"]
    assert "another unit than metres" in notes[0].text
    np.testing.assert_allclose(speeds, drive.truth, atol=1e-6)


@pytest.mark.parametrize("course", ["mixed", "circle", "lap", "sideways"])
def test_forward_speeds_with_the_wrong_sign_are_turned_round(course: str) -> None:
    drive = odometry_drive(course)
    speeds, notes = compared(drive.spoilt(scaled(vx=-1)).stream())
    assert codes(notes) == ["odometry.twist-turned"]
    np.testing.assert_allclose(speeds, drive.truth, atol=1e-6)


def test_which_sign_is_right_the_command_tells_and_without_one_nothing_does() -> None:
    drive = odometry_drive("back-and-forth")
    wrong = drive.spoilt(scaled(vx=-1)).stream()
    speeds, notes = compared(wrong)
    assert codes(notes) == ["odometry.twist-apart"]
    np.testing.assert_array_equal(speeds, wrong.columns(*SPEEDS))
    speeds, notes = compared(wrong, command=drive.stream())
    assert codes(notes) == ["odometry.twist-turned"]
    np.testing.assert_allclose(speeds, drive.truth, atol=1e-6)
    speeds, notes = compared(wrong, command=wrong)
    assert codes(notes) == ["odometry.moves-aside"], "then it is the poses that look backwards"
    np.testing.assert_array_equal(speeds, wrong.columns(*SPEEDS))


def test_which_way_it_turns_the_gyroscope_tells_or_the_way_itself() -> None:
    drive = odometry_drive("mixed")
    speeds, notes = compared(drive.spoilt(scaled(wz=-1)).stream())
    assert codes(notes) == ["odometry.twist-turned"]
    np.testing.assert_allclose(speeds, drive.truth, atol=1e-6)
    spinning = odometry_drive("rotation")
    wrong = spinning.spoilt(scaled(wz=-1)).stream()
    assert codes(compared(wrong)[1]) == ["odometry.twist-apart"], "on the spot nothing tells"
    speeds, notes = compared(wrong, imu=spinning.stream())
    assert codes(notes) == ["odometry.twist-turned"]
    np.testing.assert_allclose(speeds, spinning.truth, atol=1e-6)
    mirrored = drive.spoilt(
        lambda _, values: values.__setitem__(np.s_[:, 5], -values[:, 5])  # yaw to the right
    )
    speeds, _ = compared(mirrored.stream(), imu=drive.stream())
    np.testing.assert_array_equal(speeds[:, 2], drive.values[:, TURN], err_msg="the poses are wrong here")


@pytest.mark.parametrize(
    ("course", "angle_rad"),
    [
        *((course, sign * np.pi / 2) for course in DRIVEN if course != "straight" for sign in (1, -1)),
        *((course, 0.785) for course in ("mixed", "circle", "one-turn", "lap", "sideways")),
    ],
)
def test_velocities_aside_of_the_way_are_turned_onto_it(course: str, angle_rad: float) -> None:
    drive = odometry_drive(course)
    turn = Rotation.from_euler("z", angle_rad)
    aside = drive.spoilt(lambda _, values: values.__setitem__(np.s_[:, LINEAR], turn.apply(values[:, LINEAR])))
    speeds, notes = compared(aside.stream())
    assert codes(notes) == ["odometry.twist-turned"]
    np.testing.assert_allclose(speeds, drive.truth, atol=1e-2)


@pytest.mark.parametrize("course", ["mixed", "circle", "lap", "sideways"])
@pytest.mark.parametrize("angle_rad", [np.pi / 2, np.pi], ids=["aside", "backwards"])
def test_where_the_poses_look_aside_the_velocities_stay(course: str, angle_rad: float) -> None:
    drive = odometry_drive(course)
    turn = Rotation.from_euler("z", angle_rad)
    looks = drive.spoilt(lambda _, v: v.__setitem__(np.s_[:, 3:7], (Rotation.from_quat(v[:, 3:7]) * turn).as_quat()))
    speeds, notes = compared(looks.stream())
    assert set(codes(notes)) <= {"odometry.moves-aside"}
    np.testing.assert_array_equal(speeds, drive.stream().columns(*SPEEDS))


@pytest.mark.parametrize("how", [{}, NOISY, {"hz": 5.0}], ids=["clean", "noisy", "5-hz"])
@pytest.mark.parametrize("course", ["mixed", "circle", "reverse", "back-and-forth", "sideways"])
def test_velocities_that_drop_to_zero_for_a_while_come_from_the_poses(course: str, how: dict[str, Any]) -> None:
    drive = odometry_drive(course, **how)
    dead = drive.spoilt(held(12.0, 17.0, slice(LINEAR.start, ANGULAR.stop), 0.0))
    speeds, notes = compared(dead.stream())
    assert codes(notes) == ["odometry.twist-stale"]
    inside = (drive.time_s >= 12) & (drive.time_s <= 17)
    assert np.abs(speeds - drive.truth)[inside, 0].max() < (0.12 if how else 0.02)
    np.testing.assert_array_equal(speeds[~inside], drive.stream().columns(*SPEEDS)[~inside])


def test_velocities_that_freeze_come_from_the_poses_and_a_steady_speed_is_no_freeze() -> None:
    drive = odometry_drive("back-and-forth")
    speeds, notes = compared(drive.spoilt(held(12.0, 17.0, slice(LINEAR.start, ANGULAR.stop))).stream())
    assert codes(notes) == ["odometry.twist-stale"]
    assert "taken from the poses there" in notes[0].text
    np.testing.assert_allclose(speeds, drive.truth, atol=0.02)


def test_a_turning_rate_that_dies_halfway_comes_from_the_poses() -> None:
    drive = odometry_drive("mixed")
    speeds, notes = compared(drive.spoilt(held(15.0, 99.0, slice(TURN, TURN + 1), 0.0)).stream())
    (note,) = notes
    assert note.text.startswith("odometry: the turning rate does not change in 500 of 800 messages")
    np.testing.assert_allclose(speeds, drive.truth, atol=0.01)


@pytest.mark.parametrize("course", MOVING)
def test_poses_that_stop_while_the_velocities_go_on_make_rows_that_are_not_valid(course: str) -> None:
    drive = odometry_drive(course)
    stuck = drive.spoilt(held(13.0, 17.0, slice(0, 7)))
    speeds, notes = compared(stuck.stream())
    assert "odometry.poses-stopped" in codes(notes)
    assert set(codes(notes)) <= {"odometry.poses-stopped", "odometry.poses-jump"}
    inside = (drive.time_s >= 13) & (drive.time_s <= 17)
    np.testing.assert_array_equal(np.isnan(speeds).all(axis=1), inside)
    np.testing.assert_array_equal(speeds[~inside], drive.stream().columns(*SPEEDS)[~inside])


def test_velocities_and_poses_that_both_live_and_differ_are_told_and_left() -> None:
    drive = odometry_drive("mixed", **NOISY)
    slips = drive.spoilt(lambda t, values: values.__setitem__((np.s_[(t > 20) & (t < 25)], FORWARD), 0.1))
    wavering = slips.spoilt(lambda _, v: v.__setitem__(np.s_[:, FORWARD], v[:, FORWARD] + 1e-4 * np.arange(len(v)) % 2))
    speeds, notes = compared(wavering.stream())
    assert codes(notes) == ["odometry.twist-apart"]
    np.testing.assert_array_equal(speeds, wavering.stream().columns(*SPEEDS))


@pytest.mark.parametrize("course", COURSES)
def test_poses_that_jump_make_no_speed(course: str) -> None:
    drive = odometry_drive(course)
    jumps = drive.spoilt(jumping(97))
    speeds, notes = compared(jumps.stream())
    assert codes(notes) == ["odometry.poses-jump"]
    np.testing.assert_array_equal(speeds, drive.stream().columns(*SPEEDS))
    if course in ("mixed", "circle", "reverse"):
        speeds, _ = compared(jumps.spoilt(scaled(vx=0, vy=0, wz=0)).stream())
        np.testing.assert_allclose(speeds, drive.truth, atol=0.05)


def test_large_coordinates_are_as_good_as_small_ones() -> None:
    drive = odometry_drive("mixed")
    far = drive.spoilt(lambda _, values: values.__setitem__(np.s_[:, :2], values[:, :2] + (4.5e5, 5.4e6)))
    speeds, notes = compared(far.spoilt(scaled(vx=0, vy=0, wz=0)).stream())
    assert codes(notes) == ["state.no-twist"]
    np.testing.assert_allclose(speeds, drive.truth, atol=0.01)


def test_a_setting_has_the_word() -> None:
    drive = odometry_drive("mixed")
    parent = drive.spoilt(into_parent)
    speeds, notes = compared(parent.stream(), OdometryTwist.as_recorded)
    assert notes == []
    np.testing.assert_array_equal(speeds, parent.stream().columns(*SPEEDS))
    speeds, _ = compared(parent.stream(), OdometryTwist.parent_frame)
    np.testing.assert_allclose(speeds, drive.truth, atol=1e-9)
    speeds, _ = compared(parent.stream(), OdometryTwist.from_poses)
    np.testing.assert_allclose(speeds, drive.truth, atol=0.01)


def test_what_cannot_be_compared_stays() -> None:
    few = odometry_drive("mixed", seconds=0.15).spoilt(into_parent).stream()
    speeds, notes = compared(few)
    assert notes == []
    np.testing.assert_array_equal(speeds, few.columns(*SPEEDS))
    unset = odometry_drive("mixed").spoilt(lambda _, values: values.__setitem__(np.s_[:, 3:7], 0.0))
    speeds, notes = compared(unset.stream())
    assert notes == []
    np.testing.assert_array_equal(speeds, unset.stream().columns(*SPEEDS))


REAL = {
    "evo/nav2_turtlebot.mcap": ("/odom", []),
    "ground_vehicle_xsens/test1_2014.bag": ("/wheel_odometry", ["odometry.parent-twist"]),
    "husky_outdoor/test1.bag": ("/husky_velocity_controller/odom", []),
    "husky_sim_joint_odom/le_bag": ("/husky_velocity_controller/odom", []),
    "jackal_velodyne_scan/test_2026-02-17-16-26-34.bag": (
        "/vrpn_client_node/jackal/pose",
        ["state.no-twist", "odometry.poses-jump"],
    ),
}
"""The odometry of real recordings, and what is found there."""


@pytest.mark.slow
@pytest.mark.parametrize("name", REAL)
def test_real_odometry_gives_no_false_alarm(name: str, recordings: Path) -> None:
    topic, wanted = REAL[name]
    robot = RobotConfig(topics=TopicCandidates(odometry=[topic]))
    with open_recording(recordings / "bags" / name) as recording:
        found = first_pass(recording, resolve_topic_map(robot, recording.topics), ())
    times = Clocks.of(found, SyncConfig()).times("odometry")
    _, notes = compared(TimedStream.of(found.streams["odometry"], times["odometry"]))
    assert codes(notes) == wanted


@pytest.mark.slow
def test_another_odometry_of_the_same_drive_is_sound(recordings: Path) -> None:
    """The wheels' velocities of this recording are in the frame of their poses; those of its cameras are not."""
    robot = RobotConfig(topics=TopicCandidates(odometry=["/stereo_odometer/odometry"]))
    with open_recording(recordings / "bags/ground_vehicle_xsens/test1_2014.bag") as recording:
        found = first_pass(recording, resolve_topic_map(robot, recording.topics), ())
    times = Clocks.of(found, SyncConfig()).times("odometry")
    assert compared(TimedStream.of(found.streams["odometry"], times["odometry"]))[1] == []
