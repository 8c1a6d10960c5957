"""Finding the robot that a command is about: a preset, a file, or overrides."""

from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from navtool.configs.ingest_job import IngestJob
    from navtool.datasets.robot.config import RobotConfig


def ingest_job(robot: str | None, overrides: Sequence[str]) -> "IngestJob":
    """The job of ingest that ``--robot`` and the overrides give."""
    from navtool.configs.ingest_job import IngestJob

    return job_with_robot("ingest", robot, overrides, IngestJob)


def job_with_robot[T](config: str, robot: str | None, overrides: Sequence[str], result: type[T]) -> T:
    """The configuration that ``--robot`` and the overrides give; overrides win over the preset or the file.

    Args:
        config: Its name; it has a group of robots.
        robot: Name of a preset, or the path of a robot file (it has a suffix or a slash); None for the generic one.
        overrides: As on the command line.
        result: The dataclass behind it.
    """
    import yaml

    from navtool.base.plain import plain
    from navtool.cli.compose import UsageError, compose, quoted, wrong_call
    from navtool.datasets.robot.config import load_robot_file

    for name in [robot, *(x.removeprefix("robot=") for x in overrides if x.startswith("robot="))]:
        _check_preset(name)
    if robot is None:
        return compose(config, overrides, result)
    if any(override.startswith("robot=") for override in overrides):
        raise UsageError("--robot and robot= both name a robot", cure="use one of them")
    if "/" not in robot and "." not in robot:
        return compose(config, [f"robot={robot}", *overrides], result)
    with wrong_call():
        content = yaml.safe_dump(plain(load_robot_file(Path(robot))))
    with TemporaryDirectory() as folder:
        # Hydra takes groups from folders only: the checked file becomes the one option of a group beside ours.
        option = Path(folder) / "robot" / "from_file.yaml"
        option.parent.mkdir()
        option.write_text(f"defaults:\n  - robot_schema\n{content}", encoding="utf-8")
        found = [f"hydra.searchpath=[{quoted(f'file://{folder}')}]", "robot=from_file"]
        return compose(config, [*found, *overrides], result)


def named_streams(robot: str | None, overrides: Sequence[str], composed: "RobotConfig") -> set[str]:
    """Streams whose topics the user named, in a robot file or an override; a preset only lists candidates."""
    from navtool.datasets.robot.sensor_config import NO_TOPIC

    in_file = robot is not None and ("/" in robot or "." in robot)
    candidates = {stream: topics for stream, topics in composed.candidates().items() if topics not in ([], [NO_TOPIC])}
    return {
        stream
        for stream in candidates
        if in_file or any(override.startswith(f"robot.topics.{stream}=") for override in overrides)
    }


def _check_preset(name: str | None) -> None:
    """Refuse the name of a preset that there is none of; files are for others to look at."""
    from navtool.cli.compose import refuse_unknown

    if name is not None and "/" not in name and "." not in name:
        refuse_unknown("robot", name, "robot preset")


def find_robot(robot: str | None, overrides: Sequence[str]) -> "RobotConfig":
    """The robot that ``--robot`` and the overrides give."""
    return ingest_job(robot, overrides).robot
