"""What all episodes of a data set must have in common, and what sets two ingests of one recording apart."""

from typing import TYPE_CHECKING

from navtool.base.errors import DatasetsError
from navtool.base.lineage import config_hash
from navtool.base.plain import flatten
from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.robot.config import RobotConfig
from navtool.datasets.store.schema import Contents

if TYPE_CHECKING:
    from navtool.datasets.store.writer import Store


def settings_hash(robot: RobotConfig, config: IngestConfig) -> str:
    """Hash of what decides an episode's content; the place is only a name."""
    settings = flatten(config)
    settings.pop("place")
    return config_hash({"robot": robot, "ingest": settings})


def refuse_other_settings(store: "Store", config: IngestConfig) -> None:
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


def refuse_other_contents(fixed: Contents, found: Contents, *, allow_missing: bool) -> None:
    """A recording must have every stream that the data set has.

    Raises:
        DatasetsError: It lacks some, and that is not allowed.
    """
    missing = [name for name in _streams_of(fixed) if name not in _streams_of(found)]
    if missing and not allow_missing:
        raise DatasetsError(
            f"lacks {', '.join(missing)}, which the data set has",
            cure="pass --allow-missing to take it with these marked as not valid, or use another folder",
        )


def streams_left_out(fixed: Contents, found: Contents) -> list[str]:
    """Streams that a recording has and the data set has not."""
    return [name for name in _streams_of(found) if name not in _streams_of(fixed)]


def _streams_of(contents: Contents) -> tuple[str, ...]:
    return tuple(name for name in contents.streams() if name not in ("state", "action"))
