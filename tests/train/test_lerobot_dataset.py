"""LeRobot's data set with clouds in its samples."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from navtool.base.errors import DatasetsError
from navtool.datasets.store.reader import NavDataset

pytestmark = [pytest.mark.slow, pytest.mark.filterwarnings("ignore")]  # upstream's own warnings


@pytest.fixture(scope="module")
def opened(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("HF_HOME", str(tmp_path_factory.mktemp("hf")))
        patch.setenv("HF_HUB_OFFLINE", "1")
        from navtool.train.lerobot_dataset import NavLeRobotDataset  # noqa: PLC0415 (takes seconds and 0.9 GB)

        yield lambda root, **options: NavLeRobotDataset(root, video_backend="pyav", **options)


def test_samples_hold_the_points_of_their_rows(opened: Any, labelled_dataset: Path) -> None:
    from torch.utils.data import DataLoader  # noqa: PLC0415

    ours, dataset = NavDataset(labelled_dataset), opened(labelled_dataset, episodes=[1, 2])
    for batch in DataLoader(dataset, batch_size=40, shuffle=True, num_workers=2):
        for row, points, count in zip(batch["index"], batch["lidar.points"], batch["lidar.count"], strict=True):
            np.testing.assert_array_equal(points, ours.points(int(row)))
            assert len(ours.distinct_points(int(row))) == count
    np.testing.assert_array_equal(dataset[0:2][1]["lidar.points"], ours.points(61))


def test_whole_clouds_are_those_that_the_rows_were_made_from(opened: Any, labelled_dataset: Path) -> None:
    ours, dataset = NavDataset(labelled_dataset), opened(labelled_dataset, whole_clouds=True)
    served = {cloud.frame_index: cloud for cloud in ours.clouds(1) if cloud.frame_index >= 0}
    assert len(served) > 50
    for frame, cloud in served.items():
        row = ours.episodes[1].start + frame
        item = dataset[row]
        if not ours.column("valid.lidar")[row]:
            continue
        np.testing.assert_array_equal(item["lidar.whole.xyz"], cloud.xyz)
        np.testing.assert_array_equal(item["lidar.whole.ring"], cloud.ring)


def test_a_data_set_of_another_is_refused(opened: Any, tmp_path: Path) -> None:
    with pytest.raises(DatasetsError, match="not a data set"):
        opened(tmp_path)
