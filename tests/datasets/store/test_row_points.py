"""Clouds of rows, beside the rows."""

from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from navtool.base.errors import DatasetsError
from navtool.datasets.store.reader import NavDataset
from navtool.datasets.store.row_points import PointsFile, of_fixed_size, read_points
from navtool.pipeline.downsample import fixed_size_cloud


@settings(max_examples=20, deadline=None)
@given(sizes=st.lists(st.integers(0, 12_000), min_size=1, max_size=4), seed=st.integers(0, 1000))
def test_clouds_of_a_row_come_back_to_the_bit(
    tmp_path_factory: pytest.TempPathFactory, sizes: list[int], seed: int
) -> None:
    rng = np.random.default_rng(seed)
    made = [fixed_size_cloud(rng.uniform(-900, 900, (size, 3)).astype(np.float32)) for size in sizes]
    path = tmp_path_factory.mktemp("points") / "part.parquet"
    with PointsFile(path) as file:
        for cloud in made:
            file.add(cloud.points[: cloud.kept])
    with pq.ParquetFile(path) as opened:
        for row in rng.permutation(len(made)).tolist():
            found = read_points(opened, row)
            assert len(found) == made[row].kept
            assert of_fixed_size(found).tobytes() == made[row].points.tobytes()
        with pytest.raises(ValueError, match=f"holds points of {len(made)} rows"):
            read_points(opened, len(made))


def test_a_row_knows_the_cloud_that_it_was_made_from(labelled_dataset: Path) -> None:
    dataset = NavDataset(labelled_dataset)
    episode, valid = dataset.episodes[2], dataset.column("valid.lidar")
    served = {cloud.frame_index: cloud for cloud in dataset.clouds(2) if cloud.frame_index >= 0}
    for row in range(episode.start, episode.stop):
        cloud = dataset.whole_cloud(row)
        assert (cloud is not None) == valid[row]
        expected = served.get(row - episode.start)
        if cloud is not None and expected is not None:
            np.testing.assert_array_equal(cloud.xyz, expected.xyz)
            assert cloud.stamp_ns == expected.stamp_ns
    with pytest.raises(IndexError):
        dataset.whole_cloud(len(dataset))


def test_points_that_are_asked_for_in_vain_are_refused(labelled_dataset: Path) -> None:
    dataset = NavDataset(labelled_dataset)
    with pytest.raises(IndexError):
        dataset.points(180)
    with pytest.raises(DatasetsError, match=r"no column 'lidar.points'"):
        dataset.column("lidar.points")
