"""The whole chain on real input, as a user would run it: three containers in, one verified artefact out."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from navtool.datasets.store.reader import NavDataset

CUTS = {"ros1": 20.0, "db3": 120.0, "mcap": 240.0}
"""Container and where its cut of the real drive begins, in seconds."""
SECONDS = 8.0


@pytest.mark.slow
@pytest.mark.recordings
def test_real_recordings_become_a_verified_artefact(
    navtool: Callable[..., Any],
    composed_entries: Callable[..., Any],
    recording_writer: Callable[..., Path],
    tmp_path: Path,
) -> None:
    paths = []
    for container, first_s in CUTS.items():
        folder = tmp_path / f"field-{container}"
        folder.mkdir()
        entries = composed_entries(first_s, SECONDS, ros1=container == "ros1")
        paths.append(recording_writer(folder, container, entries, "run"))

    listing = json.loads(navtool("inspect", paths[0], "--json").out)
    assert listing["topic_map"]["camera"] == "/pylon_camera_node/image_raw/compressed"
    assert listing["topic_map"]["lidar"] == "/os1_cloud_node/points"

    dataset = tmp_path / "dataset"
    done = navtool("ingest", *paths, "--out", dataset, "--json", "place='{parent}'", "robot.base_height_m=0.3")
    assert done.code == 0, done.err
    report = json.loads(done.out)
    assert report["episodes"] == 3
    assert report["quarantined"] == []

    events = tmp_path / "events.csv"
    rows = [f"{path.parent.name}/{path.name},3.0,4.0,0,tall grass" for path in paths]
    events.write_text("\n".join(["bag,start,end,outcome,reason", *rows]) + "\n")
    done = navtool("label", dataset, "--events", events, "--json")
    assert done.code == 0, done.err
    assert json.loads(done.out)["reasons"]["tall grass"] >= 30
    done = navtool("check", dataset, "--json")
    assert done.code == 0, done.out
    _look_at(NavDataset(dataset))

    run, artefact = tmp_path / "run", tmp_path / "artefact"
    done = navtool("train", "--data", dataset, "--out", run, "experiment=demo", "trainer.epochs=1")
    assert done.code == 0, done.err
    done = navtool("evaluate", run, "--json")
    assert done.code == 0, done.err
    judged = json.loads(done.out)
    assert judged["split"] == "test"
    assert judged["metrics"]["trajectory"]["negatives"] > 0
    assert navtool("export", run, "--out", artefact).code == 0
    done = navtool("verify", artefact, "--json")
    assert done.code == 0, done.out
    assert json.loads(done.out)["passed"]
    done = navtool("evaluate", artefact, "--data", dataset, "--json")
    assert done.code == 0, done.err
    assert json.loads(done.out)["metrics"]["trajectory"]["fpr"] == judged["metrics"]["trajectory"]["fpr"]


def _look_at(dataset: NavDataset) -> None:
    """Three containers of one kind of drive: every stream is there, and the values are the real ones."""
    for stream in ("camera", "lidar", "state", "imu", "joints"):
        assert dataset.column(f"valid.{stream}").mean() > 0.9, stream
    assert dataset.description.contents.joint_names[0] == "FR_hip"
    speed = dataset.column("observation.state")[:, 0]
    assert 0.1 < np.abs(speed).max() < 1.2, "the Husky drove up to 1.02 m/s"
    gravity = np.linalg.norm(dataset.column("observation.imu")[dataset.column("valid.imu"), :3], axis=1)
    assert np.median(gravity) == pytest.approx(9.7, abs=0.4)
    # the photos are sharp and bright, the one RELLIS-3D cloud is the same throughout
    assert (dataset.column("reliability.camera")[dataset.column("valid.camera")] > 0.1).all()
    calibration = dataset.calibration(0)
    assert calibration.camera is not None
    assert calibration.camera.fx == pytest.approx(2813.643275 / 6)
    assert calibration.base_camera is not None
    forward = calibration.base_camera[:3, 2]
    assert forward[0] > 0.95, "the optical axis looks ahead"
