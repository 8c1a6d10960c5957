"""Kinds of damage to a data set, and what the check says of each."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from navtool.base.lineage import file_sha256
from navtool.datasets.store.layout import Layout
from navtool.datasets.store.reader import NavDataset
from navtool.datasets.store.rewrite import rewrite_columns
from navtool.datasets.store.schema import arrow_schema
from navtool.datasets.store.video import VideoWriter

Damage = Callable[[Path], object]


def _change(root: Path, column: str, change: Callable[[Any], Any], episode: int = 1) -> None:
    opened = NavDataset(root)
    rows = slice(opened.episodes[episode].start, opened.episodes[episode].stop)
    values = opened.column(column)[rows].copy()
    path = opened.layout.data(episode)
    changed = change(values)
    rewrite_columns(path, path.with_suffix(".new"), arrow_schema(opened.features), {column: changed})
    path.with_suffix(".new").replace(path)


def _edit_json(path: Path, **values: object) -> None:
    path.write_text(json.dumps(json.loads(path.read_text()) | values))


def _at(row: int, value: object) -> Callable[[Any], Any]:
    def change(values: Any) -> Any:
        values[row] = value
        return values

    return change


def _cut(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:-40])


def _flip(path: Path, place: int) -> None:
    content = bytearray(path.read_bytes())
    content[place] ^= 1
    path.write_bytes(content)


def _restream(root: Path, name: str, change: Callable[[dict[str, Any]], dict[str, Any]]) -> None:
    path = Layout(root).episode(2) / "streams" / f"{name}.parquet"
    table = pq.read_table(path)
    columns = {key: table.column(key).to_numpy().copy() for key in table.column_names}
    pq.write_table(pa.table(change(columns)), path)


def _nan_joint(columns: dict[str, Any]) -> dict[str, Any]:
    columns["position.front_left"][:30] = np.nan
    return columns


def _backwards(columns: dict[str, Any]) -> dict[str, Any]:
    columns["stamp_ns"][10] = columns["stamp_ns"][9]
    return columns


def _dead(columns: dict[str, Any]) -> dict[str, Any]:
    return {key: values if key.endswith("_ns") else np.full_like(values, 1.0) for key, values in columns.items()}


def _edit_feature(root: Path, key: str, entry: str, value: object) -> None:
    features = json.loads(Layout(root).info.read_text())["features"]
    features[key][entry] = value
    _edit_json(Layout(root).info, features=features)


def _miscount(root: Path) -> None:
    stats = json.loads(Layout(root).stats.read_text())
    stats["index"]["count"] = [300]
    Layout(root).stats.write_text(json.dumps(stats))


def _retype(root: Path, key: str, kind: pa.DataType | None) -> None:
    """Write a data file again with a column of another type, or without it."""
    path = Layout(root).data(1)
    table = pq.read_table(path)
    place = table.schema.get_field_index(key)
    table = table.remove_column(place) if kind is None else table.set_column(place, key, table.column(key).cast(kind))
    pq.write_table(table, path, row_group_size=4)


def _shorten(root: Path) -> None:
    path = Layout(root).data(1)
    pq.write_table(pq.read_table(path)[:-1], path, row_group_size=4)


def _film(root: Path, frames: int, still: int = 0) -> None:
    """A video of so many frames, the first of them the same, as if ingest had written it."""
    rng = np.random.default_rng(0)
    first = np.full((240, 320, 3), 90, dtype=np.uint8)
    with VideoWriter(Layout(root).video(2), 10) as video:
        for frame in range(frames):
            video.add(first if frame < still else rng.integers(0, 255, (240, 320, 3), dtype=np.uint8))
    _edit_json(Layout(root).episode(2) / "provenance.json", video_sha256=file_sha256(Layout(root).video(2)))


def _last(root: Path, *lengths_s: int) -> None:
    """Let the first episodes begin a second after one another, and last so long."""
    for episode, length_s in enumerate(lengths_s):
        start_ns = 10**18 + episode * 10**9
        beside = Layout(root).episode(episode) / "provenance.json"
        _edit_json(beside, start_ns=start_ns, end_ns=start_ns + length_s * 10**9)


def _succeed(root: Path, *, but: int) -> None:
    """Every row a success, but so many at the beginning."""
    for episode in range(3):
        _change(root, "label.outcome", np.ones_like, episode)
    if but:
        _change(root, "label.outcome", _at(0, 0), 0)


DAMAGE: dict[str, tuple[Damage, tuple[str, str], str]] = {
    "rows miscounted": (
        lambda root: _edit_json(Layout(root).info, total_frames=7),
        ("FAIL", "metadata"),
        "counts 7 rows, the episodes have 180",
    ),
    "wrong type told": (
        lambda root: _edit_feature(root, "observation.imu", "dtype", "float64"),
        ("FAIL", "metadata"),
        "lists other columns",
    ),
    "wrong shape told": (
        lambda root: _edit_feature(root, "observation.imu", "shape", [7]),
        ("FAIL", "metadata"),
        "lists other columns",
    ),
    "statistics of other rows": (
        _miscount,
        ("FAIL", "metadata"),
        r"counts \[300\] rows instead of 180",
    ),
    "statistics lost": (
        lambda root: Layout(root).stats.write_text("{}"),
        ("FAIL", "metadata"),
        "no statistics of",
    ),
    "wrong type": (
        lambda root: _retype(root, "reliability.camera", pa.float64()),
        ("FAIL", "files"),
        "columns differ from the schema's",
    ),
    "wrong shape": (
        lambda root: _retype(root, "observation.state", pa.list_(pa.float32())),
        ("FAIL", "files"),
        "columns differ from the schema's",
    ),
    "a column lost": (
        lambda root: _retype(root, "observation.pose", None),
        ("FAIL", "files"),
        "columns differ from the schema's",
    ),
    "rows lost": (
        _shorten,
        ("FAIL", "files"),
        "59 rows instead of 60",
    ),
    "entry cut": (lambda root: _cut(Layout(root).episode_meta(1)), ("FAIL", "metadata"), "cannot be read"),
    "tasks cut": (lambda root: _cut(Layout(root).tasks), ("FAIL", "files"), "cannot be opened"),
    "stream file cut": (
        lambda root: _cut(Layout(root).episode(2) / "streams" / "imu.parquet"),
        ("FAIL", "files"),
        "cannot be opened",
    ),
    "data file cut": (lambda root: _cut(Layout(root).data(1)), ("FAIL", "files"), "cannot be opened"),
    "cloud file cut": (
        lambda root: _cut(Layout(root).episode(0) / "clouds" / "part-00000.parquet"),
        ("FAIL", "files"),
        "cannot be opened",
    ),
    "provenance lost": (
        lambda root: (Layout(root).episode(2) / "sync.json").unlink(),
        ("FAIL", "files"),
        "cannot be read",
    ),
    "frame index": (
        lambda root: _change(root, "frame_index", _at(5, 9)),
        ("FAIL", "counters"),
        "frame_index does not count",
    ),
    "stamps": (
        lambda root: _change(root, "stamp_ns", lambda v: v[::-1].copy()),
        ("FAIL", "counters"),
        "true stamps do not increase",
    ),
    "off the grid": (
        lambda root: _change(root, "stamp_ns", lambda v: v + np.arange(len(v)) * 1000),
        ("FAIL", "counters"),
        "not on the grid",
    ),
    "not a number": (
        lambda root: _change(root, "observation.imu", _at(3, np.nan)),
        ("FAIL", "values"),
        "6 values are NaN or infinite",
    ),
    "reliability": (
        lambda root: _change(root, "reliability.camera", _at(3, 1.5)),
        ("FAIL", "values"),
        "1 values are outside 0 to 1",
    ),
    "outcome": (
        lambda root: _change(root, "label.outcome", _at(3, 4)),
        ("FAIL", "values"),
        "other than 0 and 1",
    ),
    "more points than counted": (
        lambda root: _change(root, "lidar.count", _at(3, 2)),
        ("FAIL", "clouds"),
        "1 clouds have another number of points than lidar.count",
    ),
    "points cut": (
        lambda root: _cut(Layout(root).points(1) / "part-00000.parquet"),
        ("FAIL", "files"),
        "cannot be opened",
    ),
    "points changed": (
        lambda root: _flip(Layout(root).points(1) / "part-00000.parquet", 300),
        ("FAIL", "clouds"),
        "cannot be read",
    ),
    "points lost": (
        lambda root: (Layout(root).points(1) / "part-00000.parquet").unlink(),
        ("FAIL", "clouds"),
        "cannot be read",
    ),
    "video cut": (lambda root: _cut(Layout(root).video(2)), ("FAIL", "video"), "cannot be decoded|frames instead"),
    "no video": (
        lambda root: Layout(root).video(2).write_bytes(bytes(5000)),
        ("FAIL", "video"),
        "cannot be decoded",
    ),
    "video lost": (lambda root: Layout(root).video(2).unlink(), ("FAIL", "video"), "cannot be decoded"),
    "frames lost": (lambda root: _film(root, 57), ("FAIL", "video"), "57 frames instead of 60"),
    "frames too many": (lambda root: _film(root, 61), ("FAIL", "video"), "61 frames instead of 60"),
    "a still picture": (
        lambda root: _film(root, 60, still=52),
        ("WARN", "video"),
        r"the picture is frozen for 5\.1 s",
    ),
    "a pause": (
        lambda root: _change(root, "valid.lidar", lambda v: v & (np.abs(np.arange(len(v)) - 30) > 15)),
        ("WARN", "streams"),
        r"lidar is missing for 3\.1 s at 1\.5 s",
    ),
    "frozen speed": (
        lambda root: _change(root, "observation.state", lambda v: np.full_like(v, 0.4)),
        ("WARN", "streams"),
        r"the measured speed is frozen for 5\.9 s",
    ),
    "native NaN": (
        lambda root: _restream(root, "joints", _nan_joint),
        ("WARN", "native"),
        r"NaN as recorded: position\.front_left 10%",
    ),
    "stream of other columns": (
        lambda root: _restream(root, "imu", lambda columns: columns | {"ax_mps2": columns["ax_mps2"].astype(str)}),
        ("FAIL", "native"),
        "columns differ",
    ),
    "stream without stamps": (
        lambda root: _restream(root, "imu", lambda columns: columns | {"stamp_ns": columns["stamp_ns"] * 1e-9}),
        ("FAIL", "native"),
        "columns differ",
    ),
    "dead IMU": (
        lambda root: _restream(root, "imu", _dead),
        ("WARN", "native"),
        r"frozen for [56]\.\d s",
    ),
    "native stamps": (
        lambda root: _restream(root, "imu", _backwards),
        ("FAIL", "native"),
        "1 true stamps do not increase",
    ),
    "dead joints": (
        lambda root: _restream(root, "joints", _dead),
        ("WARN", "native"),
        r"frozen for [56]\.\d s",
    ),
    "one outcome": (
        lambda root: _succeed(root, but=0),
        ("WARN", "labels"),
        "every row is a success",
    ),
    "rare failures": (
        lambda root: _succeed(root, but=1),
        ("WARN", "labels"),
        r"0\.56% of the rows are failures",
    ),
    "labels lost": (
        lambda root: (Layout(root).beside / "labels.json").unlink(),
        ("WARN", "labels"),
        "not labelled yet",
    ),
    "calibration": (
        lambda root: _edit_json(Layout(root).episode(2) / "calibration.json", base_lidar=None),
        ("WARN", "calibration"),
        "base_lidar unknown",
    ),
    "the same recording twice": (
        lambda root: _edit_json(
            Layout(root).episode(2) / "provenance.json",
            sha256=json.loads((Layout(root).episode(1) / "provenance.json").read_text())["sha256"],
        ),
        ("FAIL", "leakage"),
        "is the same recording as place-1",
    ),
    "the same time within another": (
        lambda root: _last(root, 20, 12, 4),
        ("WARN", "leakage"),
        r"of it are of the same time as place-2",
    ),
    "an episode in two splits": (
        lambda root: _edit_json(Layout(root).info, splits={"train": "0:2", "val": "1:3"}),
        ("FAIL", "splits"),
        "train and val share the episodes 1",
    ),
    "an episode that is not there in a split": (
        lambda root: _edit_json(Layout(root).info, splits={"train": "0:2", "val": "2:5"}),
        ("FAIL", "splits"),
        "val has the episodes 3, 4; there are 3",
    ),
    "no splits": (
        lambda root: _edit_json(Layout(root).info, splits={"train": "all"}),
        ("FAIL", "splits"),
        "train is neither a range nor a list",
    ),
    "places unknown": (
        lambda root: _edit_json(Layout(root).episode(2) / "provenance.json", place=""),
        ("WARN", "leakage"),
        "unknown for some episodes",
    ),
}
