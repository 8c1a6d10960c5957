"""A data set in one file of rows and one video a camera."""

import shutil
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from navtool.base.errors import DatasetsError
from navtool.datasets.check import check_dataset
from navtool.datasets.edit.compact import compact
from navtool.datasets.store.layout import Layout
from navtool.datasets.store.reader import NavDataset
from navtool.datasets.store.video import VideoWriter


def test_rows_and_places_in_the_video_follow_one_another(labelled_dataset: Path, tmp_path: Path) -> None:
    ours = NavDataset(labelled_dataset)
    assert compact(ours, tmp_path / "out").rows == 180
    layout = Layout(tmp_path / "out")
    table = pq.read_table(layout.data(0))
    for name in ("index", "stamp_ns", "episode_index"):
        np.testing.assert_array_equal(table.column(name).to_numpy(), ours.column(name))
    entries = pq.read_table(layout.episode_meta(0)).to_pylist()
    key = "videos/observation.images.front"
    assert [entry[f"{key}/from_timestamp"] for entry in entries] == [0.0, 6.0, 12.0]
    assert [entry[f"{key}/to_timestamp"] for entry in entries] == [6.0, 12.0, 18.0]
    assert {entry["data/file_index"] for entry in entries} == {0}
    assert len(list((tmp_path / "out").rglob("*.mp4"))) == 1


def test_a_copy_without_what_lies_beside_says_so(labelled_dataset: Path, tmp_path: Path) -> None:
    compact(NavDataset(labelled_dataset), tmp_path / "out")
    with pytest.raises(DatasetsError, match=r"nothing beside them: no clouds, .*\n.*navtool delete"):
        check_dataset(tmp_path / "out")


@pytest.mark.parametrize("damage", ["rows", "no rows", "video", "no video", "a frame too few"])
def test_damaged_files_are_named_and_nothing_is_left(damage: str, labelled_dataset: Path, tmp_path: Path) -> None:
    shutil.copytree(labelled_dataset, tmp_path / "damaged")
    layout = Layout(tmp_path / "damaged")
    file = layout.data(1) if "rows" in damage else layout.video(1, "observation.images.front")
    content = file.read_bytes()
    file.unlink()
    if damage == "a frame too few":
        with VideoWriter(file, 10) as video:
            for _ in range(59):
                video.add(np.zeros((240, 320, 3), np.uint8))
    elif not damage.startswith("no "):
        file.write_bytes(content[: len(content) // 2])
    with pytest.raises(DatasetsError, match=rf"{file.name}: (cannot be read|[0-9]+ frames instead of 60)"):
        compact(NavDataset(tmp_path / "damaged"), tmp_path / "out")
    assert not (tmp_path / "out").exists()
