"""`navtool train` as a Hydra application: its configuration printed, sweeps with a summary, runs resumed."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.ingest.ingest import ingest
from navtool.datasets.labels.apply import label_dataset
from navtool.datasets.labels.config import LabelConfig
from navtool.datasets.robot.config import RobotConfig

SMALL = (
    "trainer.epochs=1",
    "trainer.batch_size=4",
    "model.point_widths=[8,8,8,8,16]",
    "model.point_input_transform=false",
)
"""Every encoder is there; only the widths are small."""


@pytest.fixture(scope="module")
def small_dataset(
    tmp_path_factory: pytest.TempPathFactory, recording_writer: Callable[..., Path], drive_entries: Callable[..., Any]
) -> Path:
    """Three drives of 1.6 s in three places, labelled."""
    folder = tmp_path_factory.mktemp("small")
    paths = []
    for place in range(3):
        (folder / f"place-{place}").mkdir()
        paths.append(recording_writer(folder / f"place-{place}", "mcap", drive_entries(1.6, seed=place), "run"))
    ingest(paths, folder / "dataset", RobotConfig(), IngestConfig(place="{parent}"))
    label_dataset(folder / "dataset", LabelConfig())
    return folder / "dataset"


def test_cfg_job_prints_the_composed_configuration(navtool_here: Callable[..., Any]) -> None:
    shown = navtool_here("train", "--cfg", "job", "trainer.epochs=7")
    assert shown.code == 0, shown.err
    assert "epochs: 7" in shown.out
    assert "learning_rate: 0.002" in shown.out


@pytest.mark.slow
def test_a_sweep_leaves_runs_and_one_summary(navtool: Callable[..., Any], small_dataset: Path, tmp_path: Path) -> None:
    out = tmp_path / "sweep"
    done = navtool("train", "-m", "--data", small_dataset, "--out", out, "seed=1,2", *SMALL)
    assert done.code == 0, done.err
    summary = json.loads((out / "summary.json").read_text())
    assert [job["overrides"][0] for job in summary["jobs"]] == ["seed=1", "seed=2"]
    losses = [job["best_val_loss"] for job in summary["jobs"]]
    assert all(job["finished"] for job in summary["jobs"])
    assert losses[0] != losses[1], "another seed, another network"
    assert sorted(path.name for path in out.iterdir() if path.is_dir()) == ["0", "1"]
    for run in ("0", "1"):
        assert {"checkpoints", "config.json", "lineage.json", "metrics.json", "tensorboard"} <= {
            path.name for path in (out / run).iterdir()
        }


@pytest.mark.slow
def test_launchers_plug_in(navtool: Callable[..., Any], small_dataset: Path, tmp_path: Path) -> None:
    out = tmp_path / "sweep"
    launcher = ("hydra/launcher=joblib", "hydra.launcher.n_jobs=1")
    done = navtool("train", "-m", "--data", small_dataset, "--out", out, "seed=3", *launcher, *SMALL)
    assert done.code == 0, done.err
    assert json.loads((out / "summary.json").read_text())["jobs"][0]["finished"]


@pytest.mark.slow
def test_a_finished_run_goes_on_with_more_epochs_and_is_not_overwritten(
    navtool: Callable[..., Any], small_dataset: Path, tmp_path: Path
) -> None:
    run = tmp_path / "run"
    first = navtool("train", "--data", small_dataset, "--out", run, *SMALL)
    assert first.code == 0, first.err
    again = navtool("train", "--data", small_dataset, "--out", run, *SMALL)
    assert again.code == 2, "the call is wrong"
    assert "holds a run already" in again.err
    resumed = navtool("train", "--resume", run)
    assert resumed.code == 0, resumed.err
    assert json.loads((run / "metrics.json").read_text())["epochs"] == 1


def test_a_single_run_reports_to_a_program(
    navtool_here: Callable[..., Any], small_dataset: Path, tmp_path: Path
) -> None:
    done = navtool_here("train", "--data", small_dataset, "--out", tmp_path / "run", "--json", *SMALL)
    assert done.code == 0, done.err
    told = json.loads(done.out)
    assert (told["epochs"], told["run"]) == (1, (tmp_path / "run").as_posix())
    refused = navtool_here("train", "-m", "--data", small_dataset, "--json", "seed=1,2")
    assert refused.code == 2
    assert "summary.json" in refused.err


def test_a_job_that_fails_says_why_once(navtool_here: Callable[..., Any], small_dataset: Path, tmp_path: Path) -> None:
    absent = tmp_path / "weights.pt"
    setting = f"model.pretrained_image_weights={absent}"
    single = navtool_here("train", "--data", small_dataset, "--out", tmp_path / "a", setting)
    assert single.code == 2, "the call is wrong"
    assert "weights.pt" in single.err
    assert single.err.count("error:") == 1
    assert "Error executing job" not in single.err
    assert not (tmp_path / "a").exists(), "nothing was trained"
