"""What upstream makes of a data set of ours: LeRobot's own reader, and lerobot-doctor."""

import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from navtool.datasets.store.reader import NavDataset


@pytest.fixture(scope="session")
def assert_upstream_opens(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Callable[[Path], None]]:
    """``assert_upstream_opens(root)``: LeRobot reads three rows as we do, and the doctor finds no fault.

    LeRobot copies every data set into its cache, which is a temporary folder here.
    """
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("HF_HOME", str(tmp_path_factory.mktemp("hf")))
        patch.setenv("HF_HUB_OFFLINE", "1")
        yield _assert_upstream_opens


def _assert_upstream_opens(root: Path) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # upstream's own
        from lerobot.datasets.lerobot_dataset import LeRobotDataset  # noqa: PLC0415 (takes seconds and 0.9 GB)
        from lerobot_doctor.dataset_loader import load_dataset  # noqa: PLC0415
        from lerobot_doctor.runner import run_checks  # noqa: PLC0415

        theirs, ours = LeRobotDataset("local/ours", root=root, video_backend="pyav"), NavDataset(root)
        assert (len(theirs), theirs.fps, theirs.num_episodes) == (len(ours), ours.fps, len(ours.episodes))
        for row in (0, len(ours) // 2, len(ours) - 1):
            _assert_same(theirs[row], ours, row)
        results = run_checks(load_dataset(str(root))).results
    assert len(results) > 9
    assert [result for result in results if result.severity.value == "FAIL"] == []


def _assert_same(item: dict[str, Any], ours: NavDataset, row: int) -> None:
    assert set(ours.features) <= set(item)
    for key, feature in ours.features.items():
        if feature.dtype == "video":
            found = np.rint(item[key].numpy().transpose(1, 2, 0) * 255).astype(np.uint8)
            np.testing.assert_array_equal(found, ours.image(row, key.rpartition(".")[2]), err_msg=key)
        else:
            value = item[key] if isinstance(item[key], str) else item[key].numpy()
            np.testing.assert_array_equal(value, ours.column(key)[row], err_msg=key)
