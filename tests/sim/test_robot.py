import numpy as np
import pytest

from navtool.sim.robot import STEP_S, Robot, RobotLimits, RobotState
from navtool.sim.scene import BRICK, BUSH, TALL_GRASS, Material, Thing
from navtool.sim.shapes import Box, Ellipsoid

WALL = Thing(Box(3.0, 0.0, 0.2, 3.0, 2.0, 0.0), BRICK)
LIMITS = RobotLimits()


def go(robot: Robot, seconds: float, speed: float, turn: float = 0.0, *, lifted: bool = False) -> list[RobotState]:
    states = [RobotState(x_m=0.0, y_m=0.0, yaw_rad=0.0)]
    for _ in range(round(seconds / STEP_S)):
        states.append(robot.step(states[-1], speed, turn, lifted=lifted))
    return states


def soft(material: Material) -> Thing:
    return Thing(Ellipsoid(3.0, 0.0, 0.3, 0.9, 0.6), material)


def test_it_follows_a_command_on_open_ground_within_its_limits() -> None:
    states = go(Robot((), LIMITS), 4.0, 5.0, 5.0)
    speed = np.array([state.speed_mps for state in states])
    assert speed[-1] == pytest.approx(LIMITS.max_speed_mps, abs=1e-3)
    assert states[-1].turn_radps == pytest.approx(LIMITS.max_turn_radps, abs=1e-3)
    assert np.abs(np.diff(speed)).max() <= LIMITS.max_acceleration_mps2 * STEP_S + 1e-12


def test_a_constant_command_drives_a_circle() -> None:
    states = go(Robot((), LIMITS), 20.0, 0.5, 0.5)[500:]
    xy = np.array([(state.x_m, state.y_m) for state in states])
    centre = (xy.max(axis=0) + xy.min(axis=0)) / 2
    assert np.hypot(*(xy - centre).T) == pytest.approx(np.ones(len(xy)), abs=2e-3), "radius v / omega"


def test_a_wall_stops_it_abruptly_and_it_never_enters() -> None:
    robot = Robot((WALL,), LIMITS)
    states = go(robot, 6.0, 0.9)
    first = next(index for index, state in enumerate(states) if state.contact)
    stopped = next(index for index in range(first, len(states)) if states[index].speed_mps == 0.0)
    assert states[first - 1].speed_mps > 0.85
    assert (stopped - first) * STEP_S < 0.06
    assert all(state.speed_mps < 0.02 and state.contact for state in states[stopped + 1 :]), "it pushes and stays"
    nose = max(state.x_m for state in states) + LIMITS.radius_m
    assert nose == pytest.approx(2.8, abs=0.05)


def test_it_backs_off_freely_from_what_it_hit() -> None:
    robot = Robot((WALL,), LIMITS)
    state = go(robot, 6.0, 0.9)[-1]
    for _ in range(100):
        state = robot.step(state, -0.5, 0.0)
    assert state.speed_mps == pytest.approx(-0.5, abs=0.01)
    assert not state.contact


def test_a_bush_holds_it_gently_and_only_the_operator_frees_it() -> None:
    robot = Robot((soft(BUSH),), LIMITS)
    states = go(robot, 10.0, 0.8)
    speed = np.array([state.speed_mps for state in states])
    assert speed.max() == pytest.approx(0.8, abs=0.01)
    assert abs(speed[-1]) < 0.02
    assert np.abs(np.diff(speed)).max() / STEP_S < 3.0, "no blow"
    state = states[-1]
    for _ in range(300):
        state = robot.step(state, -0.4, 0.0)
    assert abs(state.x_m - states[-1].x_m) < 0.15, "it cannot free itself"
    for _ in range(300):
        state = robot.step(state, -0.4, 0.0, lifted=True)
    assert state.x_m < states[-1].x_m - 0.8


def test_tall_grass_slows_it_and_lets_it_through() -> None:
    states = go(Robot((soft(TALL_GRASS),), LIMITS), 9.0, 0.8)
    assert states[-1].x_m > 5.0
    assert 0.4 < min(state.speed_mps for state in states[200:]) < 0.75


def test_clearance_is_infinite_in_the_open_and_counts_from_the_rim() -> None:
    assert np.isinf(Robot((), LIMITS).clearance(np.zeros((2, 3)))).all()
    clearance = Robot((WALL, soft(BUSH)), LIMITS).clearance(np.array([[0.0], [0.0]]))
    assert clearance[0] == pytest.approx(3.0 - 0.9 - LIMITS.radius_m)
