"""Where an odometry's speeds come from, where a robot's settings say so."""

from enum import StrEnum


class OdometryTwist(StrEnum):
    """Where an odometry's speeds come from."""

    as_recorded = "as_recorded"
    """Its velocities, whatever its poses say."""
    parent_frame = "parent_frame"
    """Its velocities, which are in the axes of its poses' frame."""
    from_poses = "from_poses"
    """Differences of its poses."""
