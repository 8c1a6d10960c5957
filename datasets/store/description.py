"""What a data set says of itself in ``navtool/dataset.json``: the version of its schema, its contents, its making."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from navtool.base.errors import DatasetsError
from navtool.base.files import read_json
from navtool.base.plain import plain
from navtool.datasets.store.layout import Layout
from navtool.datasets.store.schema import SCHEMA_VERSION, Contents


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


def read_description(root: Path) -> Description:
    """The description of the data set in this folder.

    Raises:
        DatasetsError: If there is no data set of ours here, or one of another schema version.
    """
    if not root.is_dir():
        raise DatasetsError("no such folder", where=root, cure="name the folder that `navtool ingest --out` wrote")
    path = Layout(root).description
    if not path.is_file():
        foreign = (root / "meta" / "info.json").is_file()
        what = "a LeRobot data set that navtool did not write" if foreign else "not a data set"
        raise DatasetsError(what, where=root, cure="name a folder that `navtool ingest --out` wrote")
    content: dict[str, Any] = read_json(path, "ingest the recordings again")
    version = content.get("schema_version")
    if version != SCHEMA_VERSION:
        raise DatasetsError(
            f"written with schema version {version}, this navtool reads {SCHEMA_VERSION}",
            where=root,
            cure="ingest the recordings again, or use the navtool that wrote it",
        )
    try:
        contents: dict[str, Any] = {
            key: tuple(entry) if isinstance(entry, list) else entry for key, entry in content["contents"].items()
        }
        return Description(
            fps=int(content["fps"]),
            contents=Contents(**contents),
            robot=dict(content["robot"]),
            ingest=dict(content["ingest"]),
            config_hash=str(content["config_hash"]),
        )
    except (KeyError, TypeError, ValueError) as error:
        raise DatasetsError(f"damaged: {error}", where=path, cure="ingest the recordings again") from error
