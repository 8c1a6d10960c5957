"""A data set of schema version 2 as one of this version: its columns renamed, its clouds moved beside the rows."""

import re
import shutil
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import pyarrow.parquet as pq
from jaxtyping import Float32, Shaped

from navtool.base.errors import DatasetsError
from navtool.base.files import read_json, write_json
from navtool.base.from_plain import from_plain
from navtool.base.plain import plain_fields
from navtool.base.progress import Progress
from navtool.datasets.edit.new_data_set import EditReport, copy_file, copy_folder, counted, new_folder
from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.ingest.settings import settings_hash
from navtool.datasets.robot.config import RobotConfig
from navtool.datasets.store.data_file import write_data
from navtool.datasets.store.description import Description, contents_of, foreign
from navtool.datasets.store.layout import Layout
from navtool.datasets.store.reading import reading
from navtool.datasets.store.replace import entry_stats
from navtool.datasets.store.row_points import ROWS_PER_PART, PointsFile, points_part
from navtool.datasets.store.schema import (
    CLOUD_SIZE,
    COUNT_KEY,
    MIGRATED_VERSION,
    SCHEMA_VERSION,
    features_of,
    video_keys,
)
from navtool.datasets.store.staged_episode import EpisodeFolder
from navtool.datasets.store.stats import Stats
from navtool.datasets.store.writer import Store, open_store
from navtool.pipeline.arrays import Array

_POINTS = "observation.lidar.points"
_RENAMED = {"observation.lidar.count": COUNT_KEY, "observation.timestamp_ns": "stamp_ns"}
_IMAGE = re.compile(r"^(valid\.|sync\.error_s\.|reliability\.|)image(?=$|[.:]|_brightness|_corners)")
"""The front camera's stream and those of further ones, as keys and columns named them and notes begin with."""
_OTHER = "ingest the recordings again"


def migrate(root: Path, out: Path, progress: Progress | None = None) -> EditReport:
    """A copy of a data set of version 2 in this version's form: the same rows, images, clouds, labels and files beside.

    Raises:
        DatasetsError: It has another version, is damaged, or something is in the folder already.
        OutputError: It cannot be written.
    """
    old = Layout(root)
    if not old.description.is_file():
        raise foreign(root)
    content = read_json(old.description, _OTHER)
    version = content.get("schema_version")
    if version != MIGRATED_VERSION:
        what = f"has schema version {version}; version {MIGRATED_VERSION} becomes {SCHEMA_VERSION}"
        cure = "use it as it is" if version == SCHEMA_VERSION else "name a data set of that version"
        raise DatasetsError(what, where=root, cure=cure)
    description, before = _described(content, old.description), str(content["config_hash"])
    episodes = int(str(read_json(old.info, _OTHER)["total_episodes"]))
    count = counted(progress, episodes)
    with new_folder(out) as staging:
        with open_store(staging) as store:
            for number in range(episodes):
                folder, made = _migrated(store, old, number, description)
                if made["config_hash"] == before:
                    made["config_hash"] = description.config_hash
                store.commit(folder, description, made)
                count(str(made["source"]))
            report = EditReport(str(out), store.episodes, store.rows)
        labels = old.beside / "labels.json"
        if labels.is_file():
            shutil.copyfile(labels, Layout(staging).beside / labels.name)
    return report


def renamed(key: str) -> str:
    """What a column or a key of version 2 is called now."""
    key = _RENAMED.get(key, key.removeprefix("observation.") if key.startswith("observation.reliability.") else key)
    return _IMAGE.sub(r"\1camera", key)


def _described(content: Mapping[str, Any], path: Path) -> Description:
    robot = from_plain(RobotConfig, _renamed_keys(content["robot"]), where=path)
    config = from_plain(IngestConfig, _renamed_keys(content["ingest"]), where=path)
    return Description(
        fps=int(content["fps"]),
        contents=contents_of(_renamed_keys(content["contents"])),
        robot=plain_fields(robot),
        ingest=plain_fields(config),
        config_hash=settings_hash(robot, config),
    )


def _renamed_keys(content: Any) -> Any:
    """Parsed JSON with the streams' keys as they are called now, and texts that name one first."""
    if isinstance(content, dict):
        return {renamed(key): _renamed_keys(value) for key, value in content.items()}
    if isinstance(content, list):
        return [_renamed_keys(value) for value in content]
    return _IMAGE.sub(r"\1camera", content) if isinstance(content, str) else content


def _migrated(store: Store, old: Layout, number: int, description: Description) -> tuple[EpisodeFolder, dict[str, Any]]:
    """An episode's files in the store's staging folder, and what it was made from."""
    features = features_of(description.contents)
    with reading(old.data(number)):
        rows = pq.ParquetFile(old.data(number)).metadata.num_rows
    with reading(old.episode_meta(number)):
        stats = _stats(old.episode_meta(number), features)
    folder = EpisodeFolder(store.layout.staging, store.numbering(None), rows, stats)
    folder.root.mkdir(parents=True, exist_ok=True)
    copy_folder(old.episode(number), folder.beside)
    columns = _columns(old.data(number))
    write_data(folder.data, features, columns)
    if COUNT_KEY in columns:
        _write_points(folder.beside / "points", old.data(number), columns[COUNT_KEY].tolist())
    for key in video_keys(features):
        copy_file(old.video(number, key), folder.video(key))
    picture = folder.beside / "sync.svg"
    with reading(old.episode(number) / picture.name):
        drawn = picture.read_text()
    picture.write_text(re.sub(r"(>|follows )image(?=[<.])", r"\1camera", drawn))
    for name in ("calibration.json", "sync.json"):
        write_json(folder.beside / name, _renamed_keys(read_json(folder.beside / name, _OTHER)))
    return folder, _renamed_keys(read_json(folder.beside / "provenance.json", _OTHER))


def _stats(meta: Path, features: Mapping[str, object]) -> dict[str, Stats]:
    found = {renamed(key): value for key, value in entry_stats(meta).items()}
    return {key: found[key] for key in features if key in found}


def _columns(data: Path) -> dict[str, Shaped[Array, " rows *shape"]]:
    with reading(data):
        table = pq.read_table(data, columns=[name for name in pq.read_schema(data).names if name != _POINTS])
    columns: dict[str, Array] = {}
    for name in table.column_names:
        column = table.column(name).combine_chunks()
        nested = column.type.num_fields > 0
        values = (column.flatten() if nested else column).to_numpy(zero_copy_only=False)
        columns[renamed(name)] = values.reshape(len(column), -1) if nested else values
    return columns


def _write_points(folder: Path, data: Path, counts: list[int]) -> None:
    clouds = enumerate(_clouds(data))
    for part in range(-(-len(counts) // ROWS_PER_PART)):
        with PointsFile(points_part(folder, part)) as file:
            for _ in range(min(ROWS_PER_PART, len(counts) - part * ROWS_PER_PART)):
                row, cloud = next(clouds)
                file.add(cloud[: counts[row]])


def _clouds(data: Path) -> Iterator[Float32[Array, "10000 3"]]:
    with reading(data), pq.ParquetFile(data) as file:
        for batch in file.iter_batches(batch_size=16, columns=[_POINTS]):
            yield from batch.column(0).flatten().flatten().to_numpy().reshape(-1, CLOUD_SIZE, 3)
