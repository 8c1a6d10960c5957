"""A data set as navtool wrote it in schema version 2: clouds in the rows, the front camera's stream called image."""

import json
import re
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from navtool.datasets.store.layout import Layout
from navtool.datasets.store.reader import NavDataset

_POINTS = "observation.lidar.points"


def as_version_2(dataset: Path, out: Path) -> None:
    """Write the data set as version 2 had it."""
    shutil.copytree(dataset, out)
    opened, layout = NavDataset(dataset), Layout(out)
    for episode in opened.episodes:
        table = pq.read_table(layout.data(episode.index)).rename_columns(_old_names(layout.data(episode.index)))
        clouds = np.stack([opened.points(row) for row in range(episode.start, episode.stop)])
        table = table.append_column(_POINTS, pa.array(clouds.tolist(), pa.list_(pa.list_(pa.float32()))))
        pq.write_table(table, layout.data(episode.index), row_group_size=4)
        entry = pq.read_table(layout.episode_meta(episode.index)).to_pylist()[0]
        entry = {re.sub("^stats/(.*)/", lambda m: f"stats/{_old(m[1])}/", key): value for key, value in entry.items()}
        zero = {f"stats/{_POINTS}/{name}": [0.0] * 3 for name in ("min", "max", "mean", "std")}
        pq.write_table(pa.Table.from_pylist([entry | zero]), layout.episode_meta(episode.index))
        beside = layout.episode(episode.index)
        shutil.rmtree(beside / "points")
        for name in ("provenance.json", "calibration.json", "sync.json"):
            _edit(beside / name)
        (beside / "sync.svg").write_text(
            (beside / "sync.svg")
            .read_text()
            .replace(">camera<", ">image<")
            .replace("follows camera<", "follows image<")
        )
    _edit(layout.description, schema_version=2, config_hash="of version 2")


def _edit(path: Path, **values: object) -> None:
    content = _backwards(json.loads(path.read_text())) | values
    if path.name == "provenance.json":
        content["config_hash"] = "of version 2"
    path.write_text(json.dumps(content))


def _backwards(content: Any) -> Any:
    """The keys of streams, and texts that begin with one; ``camera`` alone is the calibration's too."""
    if isinstance(content, list):
        return [_backwards(value) for value in content]
    if isinstance(content, str):
        return re.sub("^camera(?=$|: )", "image", content)
    if not isinstance(content, dict):
        return content
    of_stream = {"lidar", "odometry"} & set(content) or any(key.startswith("camera: ") for key in content)
    return {
        re.sub(r"^camera(?=$|[.:])", "image", key) if of_stream else key: _backwards(value)
        for key, value in content.items()
    }


def _old_names(data: Path) -> list[str]:
    return [_old(name) for name in pq.read_schema(data).names]


def _old(name: str) -> str:
    name = {"stamp_ns": "observation.timestamp_ns", "lidar.count": "observation.lidar.count"}.get(name, name)
    name = re.sub(r"^reliability\.", "observation.reliability.", name)
    return re.sub(r"^(valid|sync\.error_s|observation\.reliability)\.camera", r"\1.image", name)
