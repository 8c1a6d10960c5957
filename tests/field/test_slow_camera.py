"""A camera that is slower than the grid, or pauses: the last picture stands there, not valid, counted, never black."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from ingesting import ingested
from noted import noted
from turning_drive import TurningDrive

from navtool.datasets.ingest import segment
from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.store.reader import NavDataset
from navtool.datasets.streams.config import SyncConfig

type Write = Callable[..., Path]


def unlike(dataset: NavDataset) -> list[float]:
    """How much each picture differs from that of the last valid row at or before it, else the first valid one."""
    valid = np.flatnonzero(dataset.column("valid.camera"))
    of_row = [valid[max(int(np.searchsorted(valid, row, "right")) - 1, 0)] for row in range(len(dataset))]
    pictures = [dataset.image(row).astype(int) for row in range(len(dataset))]
    assert min(picture.mean() for picture in pictures) > 50
    return [float(np.abs(pictures[row] - pictures[shown]).mean()) for row, shown in enumerate(of_row)]


@pytest.mark.parametrize(("rate_hz", "fps"), [(5, 5), (7, 7), (2.5, 2)])
def test_slow_camera(write_recording: Write, tmp_path: Path, rate_hz: float, fps: int) -> None:
    drive = TurningDrive(seconds=4.0, rates_hz={"camera": rate_hz}, streams=("camera", "odometry"))
    path = write_recording("mcap", drive.entries())
    (episode,) = ingested([path], tmp_path / "out").episodes
    dataset = NavDataset(tmp_path / "out")
    assert max(unlike(dataset)) < 6
    lacking = int((~dataset.column("valid.camera")).sum())
    (note,) = noted(episode.notes, "camera.held")
    assert f"{lacking} of {len(dataset)} rows" in note
    assert f"fps={fps}" in note
    sync = SyncConfig()
    if "sync.camera.tolerance_s=0.21" in note:
        sync.camera.tolerance_s = 0.21
    (episode,) = ingested([path], tmp_path / "proposed", config=IngestConfig(fps=fps, sync=sync)).episodes
    assert NavDataset(tmp_path / "proposed").column("valid.camera").all()
    assert not noted(episode.notes, "camera.held")


def test_pauses_across_segments_and_at_both_ends(
    write_recording: Write, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(segment, "TICKS_PER_SEGMENT", 16)
    drive = TurningDrive(seconds=7.0, streams=("lidar", "odometry", "camera"))
    start_ns = drive.entries()[0][2]
    entries = [
        (topic, kind, time_ns, fields)
        for topic, kind, time_ns, fields in drive.entries()
        if topic != "/camera/image_raw" or 2.0 <= (time_ns - start_ns) * 1e-9 % 5 < 2.9
    ]
    path = write_recording("mcap", entries)
    grid = [entry for entry in entries if entry[0] != "/camera/image_raw"]
    assert grid
    (episode,) = ingested([path], tmp_path / "out", workers=2).episodes
    assert max(unlike(NavDataset(tmp_path / "out"))) < 6
    assert episode.rows > 16
