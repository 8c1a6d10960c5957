"""What a recording has, against what its data set has."""

from collections.abc import Collection
from dataclasses import replace

from navtool.base.errors import DatasetsError
from navtool.datasets.robot.config import RobotConfig
from navtool.datasets.robot.topic_map import TopicMap
from navtool.datasets.store.schema import Contents
from navtool.datasets.streams.first_pass import FirstPass
from navtool.datasets.streams.table import of_kind, sensor_of


def contents_of(found: FirstPass) -> Contents:
    """The streams of a recording."""
    joints = found.streams.get("joints")
    beside = [stream for stream in found.streams if sensor_of(stream)]
    return Contents(
        camera="camera" in found.streams,
        lidar="lidar" in found.streams,
        imu="imu" in found.streams,
        joint_names=joints.joint_names if joints is not None else (),
        battery="battery" in found.streams,
        cameras=tuple(sensor_of(stream) for stream in of_kind("camera", beside)),
        lidars=tuple(sensor_of(stream) for stream in of_kind("lidar", beside)),
    )


def contents_to_be(found: Contents, robot: RobotConfig) -> Contents:
    """The contents of a data set whose first recording this is: further sensors are those that the robot file names."""
    return replace(found, cameras=tuple(robot.cameras), lidars=tuple(robot.lidars))


def refuse_other_contents(fixed: Contents, found: Contents, *, allow_missing: bool) -> None:
    """A recording must have every stream that the data set has, and the first one every sensor of the robot file.

    Raises:
        DatasetsError: It lacks some, and that is not allowed.
    """
    missing = [name for name in _streams_of(fixed) if name not in _streams_of(found)]
    if missing and not allow_missing:
        raise DatasetsError(
            f"lacks {', '.join(missing)}, which the data set has or is to have",
            cure="pass --allow-missing to take it with these marked as not valid, or use another folder",
        )


def refuse_missing_topics(robot: RobotConfig, topics: TopicMap, named: Collection[str]) -> None:
    """A recording must have the topics that the user named.

    Args:
        named: Streams.

    Raises:
        DatasetsError: It has none of those of a stream.
    """
    wanted = robot.candidates()
    missing = [f"{stream}: none of {', '.join(wanted[stream])}" for stream in wanted if stream in named]
    missing = [what for what in missing if what.partition(":")[0] not in topics.streams]
    if missing:
        raise DatasetsError(
            f"lacks topics that were named ({'; '.join(missing)})",
            cure="see what it has with `navtool inspect`, correct the name, or pass --allow-missing",
        )


def streams_left_out(fixed: Contents, found: Contents) -> list[str]:
    """Streams that a recording has and the data set has not."""
    return [name for name in _streams_of(found) if name not in _streams_of(fixed)]


def _streams_of(contents: Contents) -> tuple[str, ...]:
    in_rows = (name for name in contents.streams() if name not in ("state", "action"))
    return (*in_rows, *contents.lidar_streams)
