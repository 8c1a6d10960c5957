"""Settings that all episodes of a data set share, and those that set two ingests of one recording apart."""

from collections.abc import Mapping, Sequence

from navtool.base.errors import DatasetsError, OccupiedError
from navtool.base.lineage import config_hash
from navtool.base.plain import flatten
from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.robot.config import RobotConfig
from navtool.datasets.store.writer import Store
from navtool.datasets.streams.config import FurtherSync


def settings_hash(robot: RobotConfig, config: IngestConfig) -> str:
    """Hash of what decides an episode's content; the place is only a name."""
    settings = flatten(config)
    settings.pop("place")
    return config_hash({"robot": robot, "ingest": settings})


def refuse_other_settings(store: Store, config: IngestConfig) -> None:
    """One data set has one rate, one set of tolerances, one way to thin clouds and to judge reliability.

    Raises:
        OccupiedError: The data set was made with others.
    """
    if store.description is None:
        return
    there, asked = flatten(store.description.ingest), flatten(config)
    other = [key for key in {**asked, **there} if key != "place" and there.get(key) != asked.get(key)]
    if other:
        raise OccupiedError(
            "; ".join(f"the data set has {_setting(there, key)}, asked for {_value(asked, key)}" for key in other),
            where=store.layout.root,
            cure=f"{_cure(there, other)}, or ingest into another folder",
        )


def _setting(settings: Mapping[str, object], key: str) -> str:
    return f"{key}={settings[key]}" if key in settings else f"no {key}"


def _cure(there: Mapping[str, object], other: Sequence[str]) -> str:
    use = " ".join(f"{key}={there[key]}" for key in other if key in there)
    without = " ".join(key for key in other if key not in there)
    return " and ".join(
        part for part in (f"use {use}" if use else "", f"leave out {without}" if without else "") if part
    )


def _value(settings: Mapping[str, object], key: str) -> object:
    return settings.get(key, "none")


def refuse_other_sensors(robot: RobotConfig, config: IngestConfig) -> None:
    """Settings of time are of sensors that the robot has.

    Raises:
        DatasetsError: They name a further camera or LiDAR that is not in the robot's configuration.
    """
    for group, known in (("cameras", list(robot.cameras)), ("lidars", list(robot.lidars))):
        settings: dict[str, FurtherSync] = getattr(config.sync, group)
        if unknown := sorted(set(settings) - set(known)):
            listed = f"known are {', '.join(known)}" if known else "it has no further ones"
            raise DatasetsError(
                f"{', '.join(unknown)}: not among robot.{group}; {listed}",
                where=f"sync.{group}",
                cure="name the sensor in the robot file, or remove its settings",
            )
