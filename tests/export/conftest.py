"""A run and its artefact, small enough to export in a second."""

import shutil
from pathlib import Path

import pytest
import torch

from navtool.export.torchscript import export_run
from navtool.train.checkpoint import checkpoint_stamp
from navtool.train.config import TrainConfig
from navtool.train.graspe.config import GraspeConfig
from navtool.train.graspe.graspe import Graspe
from navtool.train.run_folder import RunFolder
from navtool.train.run_lineage import run_lineage
from navtool.train.splits import SplitConfig, split_episodes
from navtool.train.synthetic import SyntheticConfig, SyntheticSource


@pytest.fixture(scope="session")
def world() -> SyntheticConfig:
    """Three episodes of 12 rows, images of 64x48 pixels."""
    return SyntheticConfig(rows=12, image_height=48, image_width=64, points=50, seed=3)


@pytest.fixture(scope="session")
def config() -> TrainConfig:
    """GrASPE with every width cut down."""
    network = GraspeConfig(
        image_height=48,
        image_width=64,
        point_widths=[8, 8],
        point_hidden=[8],
        point_transform_widths=[8, 8],
        point_transform_hidden=[8],
        velocity_channels=4,
        trajectory_channels=[2, 2, 2],
        graph_channels=4,
        dense_hidden=8,
    )
    return TrainConfig(
        model=network, split=SplitConfig(train_places=["wood"], val_places=["park"], test_places=["field"])
    )


@pytest.fixture(scope="session")
def run(config: TrainConfig, world: SyntheticConfig, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a run whose network has drawn weights; read only."""
    folder = RunFolder(tmp_path_factory.mktemp("run") / "run")
    source = SyntheticSource(world)
    folder.write_config(config)
    folder.write_lineage(run_lineage(config, source, split_episodes(source.episodes, config.split), {}))
    folder.write_metrics({"best_val_loss": 0.25})
    folder.checkpoints.mkdir()
    torch.manual_seed(0)
    assert isinstance(config.model, GraspeConfig)
    network = Graspe(config.model)
    with torch.no_grad():
        for parameter in network.agnn.parameters():
            parameter.normal_(std=0.5)  # outputs that depend on the inputs
    state = {f"model.{name}": value for name, value in network.state_dict().items()}
    torch.save({"state_dict": state, "epoch": 0, "navtool": checkpoint_stamp(config)}, folder.best)
    return folder.path


@pytest.fixture(scope="session")
def exported(run: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The artefact of the run; read only."""
    return export_run(run, tmp_path_factory.mktemp("exported") / "artefact")


@pytest.fixture
def artefact(exported: Path, tmp_path: Path) -> Path:
    """A copy of the artefact to damage."""
    return shutil.copytree(exported, tmp_path / "artefact")
