"""A whole drive: where it starts, who drives, and what becomes of it."""

import logging
import math

import numpy as np

from navtool.sim.drive.command import DECIDE_S, Driver
from navtool.sim.drive.config import DriveConfig, DriverKind
from navtool.sim.drive.drive import Drive
from navtool.sim.drive.driver import RandomDriver
from navtool.sim.drive.route import find_route
from navtool.sim.drive.script import LineFollower, ScriptDriver
from navtool.sim.drive.surroundings import Surroundings
from navtool.sim.drive.vehicle import Vehicle, VehicleState
from navtool.sim.errors import SimError
from navtool.sim.world.place import World

logger = logging.getLogger(__name__)

_START, _DRIVER = 71, 72
"""Purposes of the generators: numbers that are never reused."""
_PLACES, _CLEAR_M = 400, 0.5
_AFTER_FALL_S = 1.0


def roll_out(vehicle: Vehicle, world: World, config: DriveConfig, seed: int) -> Drive:
    """What happens when somebody drives a robot through a place.

    A robot that falls is given one more second, in which it comes to rest; the drive ends there.

    Args:
        vehicle: A robot that stands in this world.
        world: The place.
        config: Who drives, for how long, from where.
        seed: Decides start, driver and the errors of the robot's own sensors: equal arguments give equal drives.

    Raises:
        SimError: The seed is negative, or the robot cannot stand where it should start, or finds no room or way.
    """
    if seed < 0:
        raise SimError(f"the seed is {seed}", where=world.config.name, cure="use a seed of 0 or more")
    surroundings = Surroundings(world)
    state = _start(vehicle, world, surroundings, config, np.random.default_rng([seed, _START]))
    driver = _driver(vehicle, world, surroundings, config, np.random.default_rng([seed, _DRIVER]))
    fallen_s = 0.0
    while state.time_s < config.duration_s - 1e-9 and fallen_s < _AFTER_FALL_S:
        command = driver.command(state)
        if command is None:
            break
        state = vehicle.step(command.speed_mps, command.turn_radps, DECIDE_S, freed=command.freed)
        fallen_s += DECIDE_S if state.fallen else 0.0
    return vehicle.drive(seed)


def _driver(
    vehicle: Vehicle, world: World, surroundings: Surroundings, config: DriveConfig, rng: np.random.Generator
) -> Driver:
    speed, turn = (
        min(sum(config.speed_mps) / 2, vehicle.speed_limit_mps),
        min(config.turn_radps, vehicle.turn_limit_radps),
    )
    match config.driver:
        case DriverKind.random:
            return RandomDriver(vehicle, surroundings, config, rng)
        case DriverKind.script:
            return ScriptDriver(config.orders, config.waypoints, speed, turn)
        case DriverKind.course:
            start = world.start_m if config.start is None else (config.start.x_m, config.start.y_m)
            return LineFollower(find_route(surroundings, start, world.goal_m, vehicle.half_width_m), speed, turn)


def _start(
    vehicle: Vehicle, world: World, surroundings: Surroundings, config: DriveConfig, rng: np.random.Generator
) -> VehicleState:
    if config.start is not None:
        return vehicle.reset(config.start.x_m, config.start.y_m, config.start.yaw_rad)
    (start_x, start_y), (goal_x, goal_y) = world.start_m, world.goal_m
    if config.driver is not DriverKind.random:
        return vehicle.reset(start_x, start_y, math.atan2(goal_y - start_y, goal_x - start_x))
    half_x, half_y = surroundings.half_extent_m
    margin = vehicle.half_width_m + _CLEAR_M
    x, y = rng.uniform(-1.0, 1.0, (2, _PLACES)) * np.array([[half_x - margin], [half_y - margin]])
    yaw = rng.uniform(-math.pi, math.pi, _PLACES)
    free = (surroundings.solid_m(x, y) > margin) & (surroundings.soft_m(x, y) > vehicle.half_width_m)
    for number in np.flatnonzero(free).tolist():
        try:
            return vehicle.reset(float(x[number]), float(y[number]), float(yaw[number]))
        except SimError as error:
            logger.debug("not started there: %s", error)
    raise SimError("there is no room for the robot to start in", where=world.config.name, cure="use another seed")
