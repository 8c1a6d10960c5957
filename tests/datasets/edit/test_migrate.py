"""Data sets of schema version 2 in this version's form."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from drive_factory import REAR, STREAMS
from hashes import hashes
from ingesting import ingested
from version_2 import as_version_2

from navtool.base.errors import DatasetsError
from navtool.base.setting_error import SettingError
from navtool.datasets.check import check_dataset
from navtool.datasets.edit.migrate import migrate, renamed
from navtool.datasets.robot.config import RobotConfig
from navtool.datasets.robot.sensor_config import FurtherCamera
from navtool.datasets.store.reader import NavDataset


def test_a_migrated_data_set_is_what_ingest_writes_now(labelled_dataset: Path, tmp_path: Path) -> None:
    as_version_2(labelled_dataset, tmp_path / "old")
    with pytest.raises(DatasetsError, match=r"schema version 2, this navtool reads 3\n.*navtool migrate"):
        NavDataset(tmp_path / "old")
    report = migrate(tmp_path / "old", tmp_path / "new")
    assert (report.episodes, report.rows) == (3, 180)
    assert check_dataset(tmp_path / "new").passed
    assert hashes(tmp_path / "new") == hashes(labelled_dataset)


def test_ingest_knows_the_recordings_of_a_migrated_data_set(
    write_recording: Callable[..., Path], drive_entries: Callable[..., Any], tmp_path: Path
) -> None:
    recording = write_recording("mcap", drive_entries(2.0, streams=(*STREAMS, *REAR)))
    robot = RobotConfig(cameras={"rear": FurtherCamera(topics=["/rear_camera/image_raw/compressed"])})
    ingested([recording], tmp_path / "dataset", robot=robot)
    as_version_2(tmp_path / "dataset", tmp_path / "old")
    migrate(tmp_path / "old", tmp_path / "new")
    assert len(ingested([recording], tmp_path / "new", robot=robot).skipped) == 1
    made, new = NavDataset(tmp_path / "dataset"), NavDataset(tmp_path / "new")
    assert new.features == made.features
    for key in ("valid.camera.rear", "reliability.camera_corners.rear", "sync.error_s.camera.rear"):
        np.testing.assert_array_equal(new.column(key), made.column(key))
    np.testing.assert_array_equal(new.image(5, "rear"), made.image(5, "rear"))


def test_other_versions_and_folders_are_refused(labelled_dataset: Path, tmp_path: Path) -> None:
    with pytest.raises(DatasetsError, match="has schema version 3; version 2 becomes 3"):
        migrate(labelled_dataset, tmp_path / "new")
    with pytest.raises(DatasetsError, match="not a data set"):
        migrate(tmp_path, tmp_path / "new")
    as_version_2(labelled_dataset, tmp_path / "old")
    description = tmp_path / "old" / "navtool" / "dataset.json"
    description.write_text(json.dumps(json.loads(description.read_text()) | {"robot": {"nam": "x"}}))
    with pytest.raises(SettingError, match="did you mean 'name'"):
        migrate(tmp_path / "old", tmp_path / "new")
    assert not (tmp_path / "new").exists()


@pytest.mark.parametrize(
    "part", ["data/chunk-000/file-001.parquet", "videos/observation.images.front/chunk-000/file-001.mp4", "sync.svg"]
)
def test_a_file_that_is_gone_or_damaged_is_named(part: str, labelled_dataset: Path, tmp_path: Path) -> None:
    as_version_2(labelled_dataset, tmp_path / "old")
    (file,) = [path for path in (tmp_path / "old").rglob("*") if path.as_posix().endswith(part)][-1:]
    file.unlink()
    with pytest.raises(DatasetsError, match=f"{file.name}: (is not there|cannot be read)"):
        migrate(tmp_path / "old", tmp_path / "new")
    if file.suffix == ".parquet":
        file.write_bytes(b"PAR1")
        with pytest.raises(DatasetsError, match=r"file-001\.parquet: cannot be read"):
            migrate(tmp_path / "old", tmp_path / "new")
    assert not (tmp_path / "new").exists()


@pytest.mark.parametrize(
    ("before", "now"),
    [
        ("observation.timestamp_ns", "stamp_ns"),
        ("observation.lidar.count", "lidar.count"),
        ("observation.reliability.image_brightness.rear", "reliability.camera_brightness.rear"),
        ("observation.reliability.cloud", "reliability.cloud"),
        ("sync.error_s.image", "sync.error_s.camera"),
        ("valid.image.rear", "valid.camera.rear"),
        ("image.rear: cannot be decoded", "camera.rear: cannot be decoded"),
        ("observation.images.front", "observation.images.front"),
        ("image_reliability", "image_reliability"),
        ("valid.lidar", "valid.lidar"),
    ],
)
def test_only_names_of_streams_change(before: str, now: str) -> None:
    assert renamed(before) == now
