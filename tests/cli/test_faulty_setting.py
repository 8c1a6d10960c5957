"""A wrong setting is named by the key that a user writes, wherever its dataclass stands."""

import pytest

from navtool.base.setting_error import SettingError
from navtool.cli.compose import UsageError, compose
from navtool.configs.ingest_job import IngestJob
from navtool.configs.train_job import TrainJob
from navtool.sim.record.config import SimulationConfig


@pytest.mark.parametrize(
    ("config", "result", "override", "said"),
    [
        ("simulate", SimulationConfig, "drive.duration_s=0", "drive.duration_s: 0 s is outside"),
        ("simulate", SimulationConfig, "recorder.drop_share=2", "recorder.drop_share: 2 is outside"),
        ("simulate", SimulationConfig, "camera.hz=100", "camera.hz: 100 Hz is outside"),
        ("ingest", IngestJob, "robot.topics.imu=[none,/imu]", "robot.topics.imu: 'none' stands"),
        ("ingest", IngestJob, "fps=0", "fps: 0 Hz is outside"),
        ("ingest", IngestJob, "sync.odometry.tolerance_s=-1", "sync.odometry.tolerance_s: -1 s is outside"),
        ("ingest", IngestJob, "sync.cameras.rear.tolerance_s=99", "sync.cameras.rear.tolerance_s: 99 s is outside"),
        ("ingest", IngestJob, "sync.lidars.rear.method=linear", "sync.lidars.rear.method: linear"),
        ("ingest", IngestJob, "sync.cameras={rear: {method: linear}}", "sync.cameras.rear.method: linear"),
        ("ingest", IngestJob, "robot.cameras.rear.topics=[]", "robot.cameras.rear.topics: [] names no topic"),
        ("ingest", IngestJob, "robot.mounting.radar.xyz_m=[1,0,0]", "robot.mounting: unknown sensors radar"),
        ("train", TrainJob, "split.val_fraction=2", "split.val_fraction: 2 is outside"),
        ("train", TrainJob, "trainer.epochs=0", "trainer.epochs: 0 is not 1 or more"),
    ],
)
def test_a_refused_setting_is_named_with_its_groups(config: str, result: type, override: str, said: str) -> None:
    data = ["dataset=x"] if config == "train" else []
    with pytest.raises(SettingError) as caught:
        compose(config, [*data, override], result)
    assert str(caught.value).startswith(said)
    assert caught.value.cure


def test_settings_below_a_name_that_the_user_chose_are_merged() -> None:
    overrides = [
        "robot.cameras.rear.topics=[/rear/image]",
        "robot.cameras.rear.mounting.xyz_m=[1,2,3]",
        "robot.mounting.imu.rpy_rad=[0,0,1]",
        "sync.cameras.rear.tolerance_s=0.2",
        "sync.cameras.rear.method=hold",
        "sync.cameras.left.clock=record",
    ]
    job = compose("ingest", overrides, IngestJob)
    rear = job.robot.cameras["rear"]
    assert rear.mounting is not None
    assert (rear.topics, rear.mounting.xyz_m) == (["/rear/image"], [1.0, 2.0, 3.0])
    assert job.robot.mounting["imu"].rpy_rad == [0.0, 0.0, 1.0]
    rear_sync, left_sync = job.sync.cameras["rear"], job.sync.cameras["left"]
    assert (rear_sync.tolerance_s, str(rear_sync.method), str(rear_sync.clock)) == (0.2, "hold", "auto")
    assert (left_sync.tolerance_s, str(left_sync.method), str(left_sync.clock)) == (0.06, "nearest", "record")


def test_the_last_of_repeated_overrides_counts_and_faults_read_as_typed() -> None:
    assert compose("ingest", ["fps=5", "fps=7", "fps=5"], IngestJob).fps == 5
    with pytest.raises(UsageError, match=r"no setting sync\.cameras\.rear\.tolerance \(did you mean 'tolerance_s'"):
        compose("ingest", ["sync.cameras.rear.tolerance=1"], IngestJob)
