"""Clouds whose numbers contradict each other, through to the rows: cloud_row_step, point_field_types."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest
from drive_factory import START_NS
from ingesting import ingested
from noted import noted
from organised_cloud import COLUMNS, ROWS, organised

CLOUD = "sensor_msgs/msg/PointCloud2"
type Make = Callable[..., Any]


def ingest_clouds(make: Callable[[int], dict[str, Any]], drive_entries: Make, writer: Make, folder: Path) -> Any:
    """The whole clouds of a data set of one drive, and its notes."""
    entries = drive_entries(1.0, streams=("odometry", "tf"))
    stamps = [START_NS + k * 100_000_000 for k in range(10)]
    entries += [("/points", CLOUD, stamp + 3_000_000, make(stamp)) for stamp in stamps]
    report = ingested([writer(folder, "mcap", sorted(entries, key=lambda x: x[2]))], folder / "dataset")
    assert not report.quarantined, report.quarantined
    parts = sorted((folder / "dataset").glob("**/clouds/**/*.parquet"))
    rows = [row for part in parts for row in pq.read_table(part).to_pylist()]
    return [
        {"xyz": decoded(row["xyz_m"]).reshape(3, -1).T, "time_s": decoded(row["time_s"])} for row in rows
    ], report.episodes[0].notes


def decoded(content: bytes | None) -> Any:
    return np.frombuffer(content or b"", np.float32)


@pytest.mark.parametrize(
    "change",
    [
        {"row_step": 0},
        {"row_step": ROWS * COLUMNS * 12},
        {"row_step": COLUMNS},
        {"width": 1, "height": 1, "row_step": ROWS * COLUMNS * 12},
        {"point_step": 0},
    ],
    ids=str,
)
def test_cloud_row_step(change: dict[str, int], drive_entries: Make, recording_writer: Make, tmp_path: Path) -> None:
    clouds, notes = ingest_clouds(lambda t: organised(t) | change, drive_entries, recording_writer, tmp_path)
    assert len(clouds) == 10
    for cloud in clouds:
        assert len(cloud["xyz"]) == ROWS * COLUMNS
        assert set(cloud["xyz"][:, 0].tolist()) == {3.0}
    (note,) = noted(notes, "cloud.size-misfit")
    assert note.startswith("lidar: ")
    assert "(10 messages)" in note


@pytest.mark.parametrize("kind", ["absolute u8", "relative i8", "flag", "doubles"])
def test_point_field_types(kind: str, drive_entries: Make, recording_writer: Make, tmp_path: Path) -> None:
    sweep = np.tile(np.arange(COLUMNS) * 1_000_000, ROWS)
    make: dict[str, Callable[[int], dict[str, Any]]] = {
        "absolute u8": lambda t: organised(t, ("timestamp", "u8", (t + sweep).astype(np.uint64))),
        "relative i8": lambda t: organised(t, ("t", "i8", sweep)),
        "flag": lambda t: organised(t, ("is_ground", "?", True)),
        "doubles": lambda t: organised(t, kind="f8"),
    }
    clouds, notes = ingest_clouds(make[kind], drive_entries, recording_writer, tmp_path)
    assert len(clouds) == 10
    for cloud in clouds:
        assert set(cloud["xyz"][:, 0].tolist()) == {3.0}
        if "8" in kind:
            np.testing.assert_allclose(cloud["time_s"], sweep * 1e-9, atol=1e-6)
    assert not noted(notes, "cloud.size-misfit")
