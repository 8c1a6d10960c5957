"""Loading a run: never code, never another run's weights, always a clear error."""

import json
import os
import pickle
import shutil
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest
import torch

from navtool.base.errors import NavtoolError
from navtool.train.checkpoint import checkpoint_stamp, load_run, read_checkpoint
from navtool.train.config import TrainConfig
from navtool.train.errors import TrainError
from navtool.train.models import kind_of
from navtool.train.run_folder import RunFolder


@pytest.fixture(scope="module")
def saved(small_config: TrainConfig, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run folder with an untrained network."""
    folder = RunFolder(tmp_path_factory.mktemp("saved"))
    folder.write_config(small_config)
    folder.write_lineage({"split": {}})
    folder.checkpoints.mkdir()
    torch.manual_seed(0)
    state = {
        f"model.{name}": value
        for name, value in kind_of(small_config.model).build(small_config.model).state_dict().items()
    }
    torch.save({"state_dict": state, "epoch": 0, "navtool": checkpoint_stamp(small_config)}, folder.best)
    return folder.path


@pytest.fixture
def run(saved: Path, tmp_path: Path) -> Path:
    """A copy to damage."""
    return shutil.copytree(saved, tmp_path / "run")


class Malicious:
    """Creates a file when it is unpickled."""

    def __init__(self, target: Path) -> None:
        self.target = target

    def __reduce__(self) -> tuple[Callable[[str], int], tuple[str]]:
        return os.system, (f"touch '{self.target}'",)


def test_a_run_gives_back_its_network(run: Path, small_config: TrainConfig) -> None:
    loaded = load_run(run)
    torch.manual_seed(0)
    expected = kind_of(small_config.model).build(small_config.model).state_dict()
    assert loaded.config == small_config
    assert not loaded.model.training
    assert all(torch.equal(value, expected[name]) for name, value in loaded.model.state_dict().items())


@pytest.mark.parametrize("writer", ["torch", "pickle", "inside"])
def test_a_checkpoint_with_code_is_refused_and_not_run(run: Path, tmp_path: Path, writer: str) -> None:
    target, best = tmp_path / "created", RunFolder(run).best
    if writer == "torch":
        torch.save({"state_dict": Malicious(target)}, best)
    elif writer == "pickle":
        best.write_bytes(pickle.dumps(Malicious(target)))
    else:  # a real checkpoint whose pickle is exchanged
        rewrite(best, "data.pkl", pickle.dumps({"navtool": Malicious(target)}, protocol=2))
    with pytest.raises(TrainError, match="it was not loaded") as caught:
        load_run(run)
    assert caught.value.cure is not None
    assert not target.exists()


def test_the_malicious_pickle_would_run(tmp_path: Path) -> None:
    target = tmp_path / "created"
    pickle.loads(pickle.dumps(Malicious(target)))  # noqa: S301 (the danger that the test above guards against)
    assert target.exists()


def rewrite(archive: Path, name: str, content: bytes) -> None:
    with zipfile.ZipFile(archive) as old:
        parts = {item: old.read(item) for item in old.namelist()}
    with zipfile.ZipFile(archive, "w") as new:
        for item, data in parts.items():
            new.writestr(item, content if item.endswith(name) else data)


def test_weights_of_another_network_are_refused(run: Path) -> None:
    folder = RunFolder(run)
    content = json.loads(folder.config.read_text(encoding="utf-8"))
    content["config"]["model"]["dense_hidden"] = 9
    folder.config.write_text(json.dumps(content), encoding="utf-8")
    with pytest.raises(TrainError, match="network_hash"):
        load_run(run)
    forged = read_checkpoint(folder.best)
    forged["navtool"] = checkpoint_stamp(folder.read_config())
    torch.save(forged, folder.best)
    with pytest.raises(TrainError, match="does not hold the network"):
        load_run(run)


def test_a_foreign_checkpoint_is_refused(run: Path) -> None:
    torch.save({"state_dict": {}}, RunFolder(run).best)
    with pytest.raises(TrainError, match="not a checkpoint of navtool"):
        load_run(run)
    torch.save(torch.zeros(3), RunFolder(run).best)
    with pytest.raises(TrainError, match="not a checkpoint of navtool"):
        load_run(run)


def test_a_missing_checkpoint_and_folder_have_cures(run: Path, tmp_path: Path) -> None:
    with pytest.raises(TrainError, match="no such checkpoint"):
        load_run(run, "last")
    with pytest.raises(TrainError, match="no such folder"):
        load_run(tmp_path / "nowhere")
    (tmp_path / "empty").mkdir()
    with pytest.raises(TrainError, match="not a training run"):
        load_run(tmp_path / "empty")


@pytest.mark.parametrize(
    ("key", "value", "message"), [("schema_version", 2, "schema version 2"), ("model", "paad", "paad")]
)
def test_other_schemas_and_models_are_refused(run: Path, key: str, value: object, message: str) -> None:
    folder = RunFolder(run)
    content = json.loads(folder.config.read_text(encoding="utf-8"))
    folder.config.write_text(json.dumps(content | {key: value}), encoding="utf-8")
    with pytest.raises(TrainError, match=message):
        load_run(run)


def test_a_config_that_is_not_ours_is_refused(run: Path) -> None:
    folder = RunFolder(run)
    content = json.loads(folder.config.read_text(encoding="utf-8"))
    content["config"]["trainer"]["epoks"] = 3
    folder.config.write_text(json.dumps(content), encoding="utf-8")
    with pytest.raises(TrainError, match="epoks"):
        load_run(run)


def test_any_damage_gives_one_clear_error(run: Path) -> None:
    best = RunFolder(run).best
    whole = best.read_bytes()
    for length in (0, 1, 100, len(whole) // 2, len(whole) - 1):
        best.write_bytes(whole[:length])
        with pytest.raises(NavtoolError):
            load_run(run)
