"""A wrong setting is named by the key that a user writes, wherever its dataclass stands."""

import pytest

from navtool.cli.compose import UsageError, compose
from navtool.configs.ingest_job import IngestJob
from navtool.configs.train_job import TrainJob
from navtool.sim.record.config import SimulationConfig


@pytest.mark.parametrize(
    ("config", "result", "override", "said"),
    [
        ("simulate", SimulationConfig, "drive.duration_s=0", "drive.duration_s is 0"),
        ("simulate", SimulationConfig, "recorder.drop_share=2", "recorder.drop_share is 2"),
        ("simulate", SimulationConfig, "camera.hz=100", "camera: need"),
        ("ingest", IngestJob, "robot.topics.imu=[none,/imu]", "robot.topics.imu: 'none' stands"),
        ("ingest", IngestJob, "fps=0", "fps = 0"),
        ("ingest", IngestJob, "sync.odometry.tolerance_s=-1", "sync.odometry.tolerance_s = -1"),
        ("train", TrainJob, "split.val_fraction=2", "split.val_fraction = 2"),
        ("train", TrainJob, "trainer.epochs=0", "trainer.epochs = 0"),
    ],
)
def test_a_refused_setting_is_named_with_its_groups(config: str, result: type, override: str, said: str) -> None:
    data = ["dataset=x"] if config == "train" else []
    with pytest.raises(UsageError) as caught:
        compose(config, [*data, override], result)
    assert str(caught.value).startswith(said)
    assert caught.value.cure
