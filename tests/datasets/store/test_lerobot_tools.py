"""What people do next with a LeRobot data set, by upstream's own code, on a data set as ingest writes it."""

import os
import re
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any
from unittest.mock import MagicMock

import numpy as np
import pytest
from ingesting import ingested

from navtool.base.errors import DatasetsError
from navtool.datasets.check import check_dataset
from navtool.datasets.edit.assemble import in_parts, together, without_episodes
from navtool.datasets.edit.compact import compact
from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.store.reader import NavDataset

pytestmark = [pytest.mark.slow, pytest.mark.filterwarnings("ignore")]  # upstream's own warnings
WINDOW = [step / 10 for step in range(-49, 1)]

type Opener = Callable[..., Any]


@pytest.fixture(scope="module")
def opened(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Opener]:
    """``opened(root, **options)``: the data set in LeRobot's reader, whose cache is a temporary folder."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("HF_HOME", str(tmp_path_factory.mktemp("hf")))
        patch.setenv("HF_HUB_OFFLINE", "1")
        from lerobot.datasets.lerobot_dataset import LeRobotDataset  # noqa: PLC0415 (takes seconds and 0.9 GB)

        yield lambda root, **options: LeRobotDataset(f"local/{root.name}", root=root, video_backend="pyav", **options)


def test_a_window_of_velocities_reads_no_clouds(opened: Opener, labelled_dataset: Path) -> None:
    dataset = opened(labelled_dataset, delta_timestamps={"observation.state": WINDOW})
    assert dataset[100]["observation.state"].shape == (50, 2)
    row = dataset.hf_dataset.data.nbytes / len(dataset)
    assert row < 1000, "LeRobot reads rows whole: one of them may not weigh more than a window of 50 allows"


def test_a_shuffled_loader_with_workers_gives_batches(opened: Opener, labelled_dataset: Path) -> None:
    from torch.utils.data import DataLoader  # noqa: PLC0415

    dataset = opened(labelled_dataset, delta_timestamps={"observation.state": WINDOW})
    batches = list(DataLoader(dataset, batch_size=32, shuffle=True, num_workers=2))
    assert sorted(int(row) for batch in batches for row in batch["index"]) == list(range(180))
    assert batches[0]["observation.state"].shape == (32, 50, 2)
    assert batches[0]["observation.images.front"].shape == (32, 3, 240, 320)


@pytest.mark.usefixtures("opened")  # LeRobot's cache
@pytest.mark.parametrize("page", ["README.md", "docs/dataset.md"])
def test_what_the_docs_show_runs_at_any_rate(
    write_recording: Callable[..., Path],
    drive_entries: Callable[..., Any],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    page: str,
) -> None:
    recordings = [write_recording("mcap", drive_entries(3.0, seed=seed), f"run-{seed}") for seed in range(2)]
    ingested(recordings, tmp_path / "dataset", config=IngestConfig(fps=5))
    monkeypatch.chdir(tmp_path)
    text = (Path(__file__).parents[3] / page).read_text()
    blocks = [block for block in re.findall(r"```python\n(.*?)```", text, re.DOTALL) if "Dataset(" in block]
    assert blocks
    for block in blocks:
        shown: dict[str, Any] = {}
        exec(block, shown)  # noqa: S102
        if "known" in shown:
            assert shown["sample"]["observation.state"].shape == (50, 2)
            assert shown["known"].shape == (10,)


def test_policies_are_offered_what_a_robot_senses(opened: Opener, labelled_dataset: Path) -> None:
    from lerobot.utils.feature_utils import dataset_to_policy_features  # noqa: PLC0415

    assert sorted(dataset_to_policy_features(opened(labelled_dataset).meta.features)) == [
        "action",
        "observation.images.front",
        "observation.imu",
        "observation.pose",
        "observation.proprioception",
        "observation.state",
    ]
    assert [key for key in NavDataset(labelled_dataset).features if "image" in key] == ["observation.images.front"]


def test_upstream_deletes_splits_merges_and_removes(opened: Opener, labelled_dataset: Path, tmp_path: Path) -> None:
    from lerobot.datasets import dataset_tools as tools  # noqa: PLC0415

    ours, theirs = NavDataset(labelled_dataset), opened(labelled_dataset)
    tools.delete_episodes(theirs, [1], tmp_path / "deleted", "local/deleted")
    tools.split_dataset(theirs, {"a": [0], "b": [1, 2]}, tmp_path / "split")
    parts = [opened(tmp_path / "split" / name) for name in ("a", "b")]
    tools.merge_datasets(parts, "local/merged", tmp_path / "merged")
    tools.remove_feature(theirs, ["lidar.count", "label.reason"], tmp_path / "removed", "local/removed")
    rows = {"deleted": [0, 59, 60, 119], "merged": [0, 60, 179], "removed": [0, 179]}
    for name, chosen in rows.items():
        edited = opened(tmp_path / name)
        for row in chosen:
            item, same = edited[row], row + (60 if (name, row >= 60) == ("deleted", True) else 0)
            assert int(item["stamp_ns"]) == ours.column("stamp_ns")[same]
            found = np.rint(item["observation.images.front"].numpy().transpose(1, 2, 0) * 255)
            np.testing.assert_array_equal(found.astype(np.uint8), ours.image(same))
        with pytest.raises(DatasetsError, match=r"nothing beside them.*\n.*navtool delete"):
            check_dataset(tmp_path / name)


def test_upstream_opens_what_our_edits_made(
    assert_upstream_opens: Callable[[Path], None], labelled_dataset: Path, tmp_path: Path
) -> None:
    whole = NavDataset(labelled_dataset)
    without_episodes(whole, [1], tmp_path / "deleted", None)
    in_parts(whole, {"a": [0], "b": [1, 2]}, tmp_path, None)
    together([NavDataset(tmp_path / "b"), NavDataset(tmp_path / "a")], tmp_path / "merged", None)
    for name in ("deleted", "a", "b", "merged"):
        assert_upstream_opens(tmp_path / name)
        assert check_dataset(tmp_path / name).passed


def test_the_streaming_reader_reads_a_compact_copy(
    opened: Opener, labelled_dataset: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from lerobot.datasets import streaming_dataset  # noqa: PLC0415
    from lerobot.datasets.video_utils import decode_video_frames  # noqa: PLC0415

    def decoded(path: str, stamps: list[float], tolerance_s: float, **_: object) -> Any:
        return decode_video_frames(path, stamps, tolerance_s, backend="pyav")

    # torchcodec, which this reader insists on, needs FFmpeg's libraries on the machine
    monkeypatch.setattr(streaming_dataset, "decode_video_frames_torchcodec", decoded)
    compact(NavDataset(labelled_dataset), tmp_path / "compact")
    windows = {"observation.state": [-0.1, 0.0]}
    stream = streaming_dataset.StreamingLeRobotDataset(
        "local/compact", root=tmp_path / "compact", shuffle=False, buffer_size=20, delta_timestamps=windows
    )
    direct = opened(labelled_dataset, delta_timestamps=windows)
    items = {int(item["index"]): item for item in stream}
    assert sorted(items) == list(range(180))
    for row in (0, 30, 60, 119, 120, 179):
        for key in ("observation.images.front", "observation.state", "stamp_ns"):
            np.testing.assert_array_equal(items[row][key], direct[row][key], err_msg=f"{key} of {row}")


def test_act_trains_a_step(labelled_dataset: Path, tmp_path: Path) -> None:
    settings = {
        "dataset.repo_id": "local/drives",
        "dataset.root": labelled_dataset,
        "dataset.video_backend": "pyav",
        "policy.type": "act",
        "policy.device": "cpu",
        "policy.push_to_hub": "false",
        "policy.pretrained_backbone_weights": "null",
        "policy.dim_model": 32,
        "policy.n_heads": 2,
        "policy.dim_feedforward": 32,
        "policy.chunk_size": 5,
        "policy.n_action_steps": 5,
        "output_dir": tmp_path / "run",
        "steps": 1,
        "batch_size": 2,
        "num_workers": 0,
        "wandb.enable": "false",
    }
    _called("lerobot_train", settings, tmp_path)
    assert list((tmp_path / "run" / "checkpoints").iterdir())


def test_the_edit_command_tells_and_deletes(labelled_dataset: Path, tmp_path: Path) -> None:
    data = {"repo_id": "local/drives", "root": labelled_dataset}
    told = _called(
        "lerobot_edit_dataset", data | {"operation.type": "info", "operation.show_features": "true"}, tmp_path
    )
    assert "reliability.cloud" in told
    delete = {"operation.type": "delete_episodes", "operation.episode_indices": "[0]"}
    made = {"new_repo_id": "local/left", "new_root": tmp_path / "left"}
    _called("lerobot_edit_dataset", data | delete | made, tmp_path)
    with pytest.raises(DatasetsError, match=r"nothing beside them"):
        check_dataset(tmp_path / "left")


def _called(script: str, settings: Mapping[str, object], folder: Path) -> str:
    """What a command of LeRobot's prints."""
    call = [sys.executable, "-m", f"lerobot.scripts.{script}", *(f"--{key}={value}" for key, value in settings.items())]
    env = os.environ | {"HF_HOME": str(folder / "hf"), "HF_HUB_OFFLINE": "1"}
    done = subprocess.run(call, capture_output=True, text=True, env=env, check=False)  # noqa: S603
    assert done.returncode == 0, done.stderr[-2000:]
    return done.stdout + done.stderr


def test_a_push_to_the_hub_takes_all_that_lies_beside(
    opened: Opener, labelled_dataset: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from lerobot.datasets import lerobot_dataset  # noqa: PLC0415

    hub, dataset = MagicMock(), opened(labelled_dataset)
    monkeypatch.setattr(lerobot_dataset, "HfApi", lambda: hub)
    monkeypatch.setattr("huggingface_hub.DatasetCard.push_to_hub", lambda *_, **__: None)
    dataset.push_to_hub(tag_version=False)
    (sent,) = hub.upload_folder.call_args_list
    assert sent.kwargs["folder_path"] == labelled_dataset
    assert (sent.kwargs["allow_patterns"], sent.kwargs["ignore_patterns"]) == (None, ["images/"])
