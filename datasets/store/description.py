"""What a data set says of itself in ``navtool/dataset.json``: the version of its schema, its contents, its making."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from navtool.base.errors import DatasetsError
from navtool.base.files import read_json
from navtool.base.plain import plain
from navtool.datasets.store.layout import Layout
from navtool.datasets.store.schema import MIGRATED_VERSION, SCHEMA_VERSION, STAMP_KEY, Contents


@dataclass(frozen=True, slots=True)
class Description:
    """A data set's fixed properties, set by the first ingest."""

    fps: int
    contents: Contents
    robot: dict[str, Any]
    ingest: dict[str, Any]
    config_hash: str

    def to_json(self) -> dict[str, object]:
        """The content of ``dataset.json``."""
        return {
            "schema_version": SCHEMA_VERSION,
            "fps": self.fps,
            "contents": plain(self.contents),
            "robot": self.robot,
            "ingest": self.ingest,
            "config_hash": self.config_hash,
        }


def foreign(root: Path) -> DatasetsError:
    """What is said of a folder that is no data set of ours, or not one any more."""
    info = Layout(root).info
    features = read_json(info, "name another folder").get("features") if info.is_file() else None
    if isinstance(features, dict) and STAMP_KEY in features:
        return DatasetsError(
            "has rows that navtool wrote, and nothing beside them: no clouds, streams at their own rates, calibration, "
            "provenance or settings of the labels; `navtool compact` or a tool of LeRobot's made it",
            where=root,
            cure="run `navtool delete`, `split` or `merge` on the data set that it was made from, which keep all of "
            f"that; LeRobot's tools leave it as {root.name}_old where they edit in place",
        )
    what = "not a data set" if features is None else "a LeRobot data set that navtool did not write"
    return DatasetsError(what, where=root, cure="name a folder that `navtool ingest --out` wrote")


def contents_of(content: Mapping[str, Any]) -> Contents:
    """The contents as ``dataset.json`` holds them, as such."""
    given: dict[str, Any] = {key: tuple(entry) if isinstance(entry, list) else entry for key, entry in content.items()}
    return Contents(**given)


def read_description(root: Path) -> Description:
    """The description of the data set in this folder.

    Raises:
        DatasetsError: If there is no data set of ours here, or one of another schema version.
    """
    if not root.is_dir():
        raise DatasetsError("no such folder", where=root, cure="name the folder that `navtool ingest --out` wrote")
    path = Layout(root).description
    if not path.is_file():
        raise foreign(root)
    content: dict[str, Any] = read_json(path, "ingest the recordings again")
    version = content.get("schema_version")
    if version != SCHEMA_VERSION:
        raise DatasetsError(
            f"written with schema version {version}, this navtool reads {SCHEMA_VERSION}",
            where=root,
            cure="run `navtool migrate` on it"
            if version == MIGRATED_VERSION
            else "ingest the recordings again, or use the navtool that wrote it",
        )
    try:
        return Description(
            fps=int(content["fps"]),
            contents=contents_of(content["contents"]),
            robot=dict(content["robot"]),
            ingest=dict(content["ingest"]),
            config_hash=str(content["config_hash"]),
        )
    except (KeyError, TypeError, ValueError) as error:
        raise DatasetsError(f"damaged: {error}", where=path, cure="ingest the recordings again") from error
