"""What upstream says of our data sets: LeRobot's own reader and statistics, and lerobot-doctor."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from drive_factory import REAR, STREAMS
from ingesting import ingested

from navtool.datasets.robot.config import RobotConfig
from navtool.datasets.robot.sensor_config import FurtherCamera
from navtool.datasets.store.reader import NavDataset
from navtool.datasets.store.stats import column_stats

HISTORY, HORIZON, FPS = 50, 10, 10


@pytest.fixture(scope="module")
def upstream(labelled_dataset: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """The data set in LeRobot's reader, asked for the velocity history and the labels of the horizon."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("HF_HOME", str(tmp_path_factory.mktemp("hf")))  # it copies every data set into its cache
        patch.setenv("HF_HUB_OFFLINE", "1")
        from lerobot.datasets.lerobot_dataset import LeRobotDataset  # noqa: PLC0415 (takes seconds and 0.9 GB)

        windows = {
            "observation.state": [step / FPS for step in range(1 - HISTORY, 1)],
            "label.outcome": [step / FPS for step in range(HORIZON)],
        }
        yield LeRobotDataset("local/drives", root=labelled_dataset, delta_timestamps=windows, video_backend="pyav")


@pytest.mark.filterwarnings("ignore")  # upstream's own
def test_upstream_reads_what_we_read(upstream: Any, labelled_dataset: Path) -> None:
    ours = NavDataset(labelled_dataset)
    assert len(upstream) == len(ours)
    assert upstream.fps == ours.fps
    rng = np.random.default_rng(0)
    for row in sorted(rng.choice(len(ours), 6, replace=False).tolist()):
        item = upstream[row]
        image = np.rint(item["observation.images.front"].numpy().transpose(1, 2, 0) * 255).astype(np.uint8)
        np.testing.assert_array_equal(image, ours.image(row))
        for key, feature in ours.features.items():
            if feature.dtype != "video" and len(feature.shape) == 1 and key not in upstream.delta_timestamps:
                found = item[key] if isinstance(item[key], str) else item[key].numpy()
                np.testing.assert_array_equal(found, ours.column(key)[row], err_msg=key)


@pytest.mark.filterwarnings("ignore")  # upstream's own
def test_delta_timestamps_give_the_history_and_the_labels(upstream: Any, labelled_dataset: Path) -> None:
    ours = NavDataset(labelled_dataset)
    state, outcome, known = (ours.column(key) for key in ("observation.state", "label.outcome", "label.known"))
    episode = ours.episodes[1]  # between two others
    for row in (episode.start, episode.start + 30, episode.stop - 3):
        item = upstream[row]
        past = np.clip(np.arange(row - HISTORY + 1, row + 1), episode.start, None)
        np.testing.assert_array_equal(item["observation.state"].numpy(), state[past])
        ahead = np.arange(row, row + HORIZON)
        padded = ahead >= episode.stop
        np.testing.assert_array_equal(item["label.outcome_is_pad"].numpy(), padded)
        np.testing.assert_array_equal(item["label.outcome"].numpy()[~padded], outcome[ahead[~padded]], err_msg="E_t")
        mask = item["label.known"].numpy() & ~item["label.outcome_is_pad"].numpy()
        np.testing.assert_array_equal(mask, known[row] & ~padded)


@pytest.mark.filterwarnings("ignore")  # upstream's own
def test_column_stats_equal_upstreams(upstream: Any) -> None:
    from lerobot.datasets.compute_stats import get_feature_stats  # noqa: PLC0415

    assert upstream.meta.stats["observation.images.front"]["mean"].shape == (3, 1, 1)
    values = np.random.default_rng(0).normal(size=(2000, 3)).astype(np.float32)
    theirs = get_feature_stats(values, axis=0, keepdims=False)
    ours = column_stats(values)
    assert set(ours) == set(theirs)
    for name in ("min", "max", "mean", "std", "count"):
        np.testing.assert_allclose(ours[name], theirs[name], rtol=1e-5, atol=1e-6)
    for name in ("q10", "q50", "q90"):  # theirs are read off a coarse histogram
        np.testing.assert_allclose(ours[name], theirs[name], atol=0.1)


@pytest.mark.filterwarnings("ignore")  # upstream's own
def test_doctor_finds_no_fail(labelled_dataset: Path) -> None:
    from lerobot_doctor.dataset_loader import load_dataset  # noqa: PLC0415
    from lerobot_doctor.runner import run_checks  # noqa: PLC0415

    results = run_checks(load_dataset(str(labelled_dataset))).results
    assert len(results) >= 10
    assert [result for result in results if result.severity.value == "FAIL"] == []


@pytest.mark.filterwarnings("ignore")  # upstream's own
def test_upstream_reads_every_camera(
    assert_upstream_opens: Callable[[Path], None],
    write_recording: Callable[..., Path],
    drive_entries: Callable[..., Any],
    tmp_path: Path,
) -> None:
    recording = write_recording("mcap", drive_entries(1.5, streams=(*STREAMS, *REAR)))
    robot = RobotConfig(cameras={"rear": FurtherCamera(topics=["/rear_camera/image_raw/compressed"])})
    assert ingested([recording], tmp_path / "out", robot=robot).quarantined == []
    assert "observation.images.rear" in NavDataset(tmp_path / "out").features
    assert_upstream_opens(tmp_path / "out")
