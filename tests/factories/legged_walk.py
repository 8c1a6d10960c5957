"""Walks of the quadruped on a ground without a place around it."""

from navtool.sim.legged.controller_config import CONTROL_S
from navtool.sim.legged.robot import LeggedRobot
from navtool.sim.legged.track import LeggedTrack, track_of


def walk_straight(robot: LeggedRobot, seconds: float, speed_mps: float) -> LeggedTrack:
    """Straight on for a time, or until it falls."""
    state = robot.state()
    while state.time_s < seconds - 1e-9 and not state.fallen:
        state = robot.step(speed_mps, 0.0, CONTROL_S)
    return track_of(robot, seed=1)
