"""Settings that all episodes of a data set share, and those that set two ingests of one recording apart."""

from navtool.base.errors import DatasetsError
from navtool.base.lineage import config_hash
from navtool.base.plain import flatten
from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.robot.config import RobotConfig
from navtool.datasets.store.writer import Store


def settings_hash(robot: RobotConfig, config: IngestConfig) -> str:
    """Hash of what decides an episode's content; the place is only a name."""
    settings = flatten(config)
    settings.pop("place")
    return config_hash({"robot": robot, "ingest": settings})


def refuse_other_settings(store: Store, config: IngestConfig) -> None:
    """One data set has one rate, one set of tolerances, one way to thin clouds and to judge reliability.

    Raises:
        DatasetsError: The data set was made with others.
    """
    if store.description is None:
        return
    there, asked = flatten(store.description.ingest), flatten(config)
    other = [key for key in asked if key != "place" and there.get(key) != asked[key]]
    if other:
        raise DatasetsError(
            "; ".join(f"the data set has {key}={there.get(key)}, asked for {asked[key]}" for key in other),
            where=store.layout.root,
            cure=f"use {' '.join(f'{key}={there.get(key)}' for key in other)}, or ingest into another folder",
        )
