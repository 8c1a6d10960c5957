import dataclasses
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from navtool.sim.errors import SimError
from navtool.sim.legged.body import FOOT_RADIUS_M, PROBE_RADIUS_M, PROBES, STEP_S, TRUNK_PROBES, torque_limit
from navtool.sim.legged.footings import Patch, concrete, rocks
from navtool.sim.legged.gaits import GAITS, GaitName
from navtool.sim.legged.ground import SOLE_NPM
from navtool.sim.legged.obstacle import Form, Obstacle
from navtool.sim.legged.robot import LeggedRobot
from navtool.sim.legged.samples import Samples
from navtool.sim.legged.track import LeggedTrack

EVERY_GAIT = pytest.mark.parametrize("gait", list(GaitName))


def same(first: Samples, second: Samples) -> bool:
    return all(
        np.array_equal(getattr(first, field.name), getattr(second, field.name)) for field in dataclasses.fields(Samples)
    )


def test_a_standing_robot_stays_where_it_is() -> None:
    robot = LeggedRobot(concrete())
    robot.step(0.0, 0.0, 1.0)
    before = robot.state()
    after = robot.step(0.0, 0.0, 4.0)
    assert after.position_m == pytest.approx(before.position_m, abs=0.002)
    assert after.yaw_rad == pytest.approx(before.yaw_rad, abs=0.002)
    assert sum(after.foot_force_n) == pytest.approx(32.5 * 9.81, rel=0.01)
    assert robot.samples().standing.all()


@pytest.mark.parametrize("stiffness", [4_000.0, 14_000.0, 1e6])
def test_a_foot_sinks_in_by_its_load_over_the_stiffness(stiffness: float) -> None:
    ground = dataclasses.replace(concrete(), stiffness_npm=stiffness, damping_nspm=600.0)
    robot = LeggedRobot(ground)
    robot.step(0.0, 0.0, 2.0)
    samples = robot.samples()
    load = samples.foot_force_n[-1]
    depth = FOOT_RADIUS_M - samples.foot_m()[-1, :, 2]
    expected = load * (1 / stiffness + 1 / SOLE_NPM)
    assert depth == pytest.approx(expected, rel=0.03, abs=1e-5)


@EVERY_GAIT
def test_it_keeps_the_commanded_speed_on_level_ground(
    gait: GaitName, on_concrete: Callable[[GaitName], LeggedTrack]
) -> None:
    track = on_concrete(gait)
    speed = track.truth.command[-1, 0]
    moved = track.truth.position_m[-1] - track.truth.position_m[1250]
    assert moved[0] / (STEP_S * (len(track.truth.fallen) - 1251)) == pytest.approx(speed, rel=0.04)
    assert abs(moved[1]) < 0.15
    assert not track.truth.fallen.any()
    assert not track.failures


@pytest.mark.parametrize("turn", [0.2, -0.5])
def test_it_keeps_the_commanded_turn(turn: float) -> None:
    robot = LeggedRobot(concrete())
    robot.step(0.3, turn, 1.0)
    before = robot.state().yaw_rad
    after = robot.step(0.3, turn, 1.6).yaw_rad
    assert (after - before) / 1.6 == pytest.approx(turn, rel=0.08)


def test_it_walks_backwards_and_stops() -> None:
    robot = LeggedRobot(concrete())
    assert robot.step(-0.3, 0.0, 2.0).position_m[0] < -0.4
    robot.step(0.0, 0.0, 1.2)
    assert np.hypot(*robot.step(0.0, 0.0, 0.8).velocity_mps[:2]) < 0.01
    assert robot.samples().standing[-200:].all()


def test_a_gait_does_not_go_faster_than_it_can() -> None:
    robot = LeggedRobot(concrete(), gait=GaitName.CRAWL)
    robot.step(1.5, 0.0, 1.5)
    before = robot.state().position_m[0]
    went = robot.step(1.5, 0.0, 1.5).position_m[0] - before
    assert went / 1.5 == pytest.approx(GAITS[GaitName.CRAWL].top_speed_mps, rel=0.06)


def test_no_joint_gives_more_than_its_motor_can() -> None:
    robot = LeggedRobot(rocks(1))
    robot.step(0.6, 0.0, 1.5)
    samples = robot.samples()
    limit = np.array([torque_limit(angles) for angles in samples.joint_rad])
    # the limit holds for the angle at the controller's step, up to 4 ms before
    assert (np.abs(samples.torque_nm) <= limit + 4.0).all()
    assert np.abs(samples.torque_nm[:, ::3]).max() <= 44.89


@EVERY_GAIT
def test_the_same_calls_give_the_same_motion_to_the_bit(gait: GaitName) -> None:
    first, second = LeggedRobot(rocks(2), gait=gait), LeggedRobot(rocks(2), gait=gait)
    for robot in (first, second):
        robot.step(0.3, 0.1, 0.8)
    assert same(first.samples(), second.samples())
    used = LeggedRobot(rocks(2), gait=gait)
    used.step(0.2, -0.3, 0.4)
    used.reset()
    used.step(0.3, 0.1, 0.8)
    assert same(first.samples(), used.samples()), "a reset forgets everything"


def test_time_steps_can_be_cut_anyhow() -> None:
    coarse, fine = LeggedRobot(concrete()), LeggedRobot(concrete())
    coarse.step(0.4, 0.0, 0.4)
    for _ in range(100):
        fine.step(0.4, 0.0)
    assert same(coarse.samples(), fine.samples())
    with pytest.raises(SimError, match="multiple"):
        coarse.step(0.4, 0.0, 0.0051)


def test_it_starts_where_it_is_put() -> None:
    robot = LeggedRobot(rocks(3))
    state = robot.reset(2.0, -1.0, 2.5)
    assert state.position_m[:2] == (2.0, -1.0)
    assert state.yaw_rad == pytest.approx(2.5)
    assert not robot.step(0.0, 0.0, 1.0).fallen


def test_it_does_not_start_inside_an_obstacle() -> None:
    tree = Obstacle(name="tree", form=Form.CYLINDER, centre_m=(3.0, 0.0, 1.0), size_m=(0.2, 1.0, 0.0))
    robot = LeggedRobot(concrete(), [tree])
    with pytest.raises(SimError, match="inside tree"):
        robot.reset(3.0, 0.0)


def test_a_wall_stops_it() -> None:
    wall = Obstacle(name="wall", form=Form.BOX, centre_m=(1.5, 0.0, 0.5), size_m=(0.1, 2.0, 0.5))
    robot = LeggedRobot(concrete(), [wall])
    touched = False
    for _ in range(18):
        state = robot.step(0.5, 0.0, 0.2)
        touched = touched or state.touches == "wall"
        assert state.position_m[0] < 1.4 - 0.3
    assert touched


@pytest.mark.parametrize("damping_nspm", [0.0, 1e5, 1e7])
@pytest.mark.parametrize("stiffness_npm", [2e3, 1e9])
def test_no_ground_is_too_hard_or_too_tough_for_the_physics(stiffness_npm: float, damping_nspm: float) -> None:
    ground = dataclasses.replace(concrete(), stiffness_npm=stiffness_npm, damping_nspm=damping_nspm)
    state = LeggedRobot(ground).step(0.5, 0.0, 0.8)
    assert np.linalg.norm(state.velocity_mps) < 1.5


def test_physics_that_diverge_are_not_taken_for_a_drive(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)  # MuJoCo writes a log where it is
    robot = LeggedRobot(concrete())
    robot.step(0.0, 0.0, 0.02)
    robot.data.qvel[:] = 1e12
    with pytest.raises(SimError, match=r"0\.02\d s after the reset: the physics diverged"):
        robot.step(0.0, 0.0)


def test_what_touches_the_ground_meets_it_where_it_is_now() -> None:
    robot = LeggedRobot(rocks(2))
    robot.data.qvel[3] = 25.0  # thrown over, its motors are off: knees and trunk come down
    touched = np.zeros(PROBES, bool)
    for _ in range(500):
        centre = robot.data.geom_xpos[robot.ground.probes].copy()
        robot.step(0.0, 0.0)
        contact = robot.terrain.contact(centre, PROBE_RADIUS_M)
        deep = ((centre - contact.point_m) * contact.normal).sum(axis=1) < PROBE_RADIUS_M
        assert np.array_equal(robot.data.mocap_pos[deep], contact.point_m[deep])
        touched |= deep
    assert robot.state().fallen
    assert touched[4:8].any()
    assert touched[TRUNK_PROBES].any()


def test_slippery_ground_makes_feet_slide() -> None:
    slid = []
    for friction in (0.9, 0.3, 0.22):
        robot = LeggedRobot(dataclasses.replace(concrete(), friction=friction))
        robot.step(0.5, 0.0, 2.0)
        slid.append(_slid_m(robot.samples()))
    assert slid[0] < slid[1] < slid[2]


def _slid_m(samples: Samples) -> float:
    step = np.hypot(*np.moveaxis(np.diff(samples.foot_m()[..., :2], axis=0), -1, 0))
    return float(step[samples.foot_force_n[1:] > 25.0].sum())


def test_plants_cost_current() -> None:
    drawn = []
    for drag in (0.0, 60.0, 150.0):
        plants: Patch = dataclasses.replace(concrete(), drag_nspm2=drag, cover_m=0.4)
        robot = LeggedRobot(plants)
        robot.step(0.5, 0.0, 2.0)
        samples = robot.samples()
        drawn.append(float(np.maximum(samples.torque_nm * samples.joint_radps, 0.0).sum(axis=1)[500:].mean()))
        assert (samples.drag_n.max() > 0) == (drag > 0)
    assert drawn[0] * 1.1 < drawn[1] < drawn[2]
