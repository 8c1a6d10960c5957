"""What of a world stops the quadruped, as solid bodies."""

import numpy as np

from navtool.sim.legged.obstacle import Form, Obstacle
from navtool.sim.world.place import World

_BURIED_M = 0.5
"""How far a body goes on below the ground at its middle, so that it reaches the ground on a slope."""


def world_obstacles(world: World) -> tuple[Obstacle, ...]:
    """Return everything in a world that does not yield, upright between its outline's edges, in the world's order."""
    found = []
    for item in world.obstacles.only(pliable=False).items:
        ground_m = float(world.ground.height_at(np.array([item.x_m]), np.array([item.y_m]))[0])
        half_m = 0.5 * (item.height_m + _BURIED_M)
        centre = (item.x_m, item.y_m, ground_m + item.height_m - half_m)
        if item.half_width_m is None:
            form, size = Form.CYLINDER, (item.half_length_m, half_m, 0.0)
        else:
            form, size = Form.BOX, (item.half_length_m, item.half_width_m, half_m)
        found.append(Obstacle(name=item.kind, form=form, centre_m=centre, size_m=size, yaw_rad=item.yaw_rad))
    return tuple(found)
