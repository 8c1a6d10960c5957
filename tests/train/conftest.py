"""A small world and a small network, so that a run takes seconds."""

import pytest

from navtool.train.config import Device, TrainConfig, TrainerConfig
from navtool.train.graspe.config import GraspeConfig
from navtool.train.splits import SplitConfig
from navtool.train.synthetic import SyntheticConfig


@pytest.fixture(scope="session")
def small_world() -> SyntheticConfig:
    """Three episodes of 12 rows, successes and failures in training and validation, images of 64x48 pixels."""
    return SyntheticConfig(rows=12, image_height=48, image_width=64, points=50, seed=3)


@pytest.fixture(scope="session")
def small_config() -> TrainConfig:
    """Two epochs of GrASPE on the CPU, with every width cut down."""
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
        model=network,
        trainer=TrainerConfig(epochs=2, batch_size=8, device=Device.cpu, figure_samples=1),
        split=SplitConfig(train_places=["wood"], val_places=["park"], test_places=["field"]),
        seed=1,
    )
