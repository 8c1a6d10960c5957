"""What a sample holds, with and without a cache, in this process and in another."""

import pickle

import numpy as np
import torch

from navtool.pipeline.geometry.trajectory_image import TrajectoryImageConfig, trajectory_image
from navtool.train.frame_cache import FrameCache
from navtool.train.samples import Sample, SampleDataset
from navtool.train.synthetic import SyntheticConfig, SyntheticSource
from navtool.train.windows import DataConfig, MissingModality, plan_windows

SMALL = SyntheticConfig(rows=30, image_height=24, image_width=32)
CONFIG = DataConfig(history_steps=6)


def samples(source: SyntheticSource, config: DataConfig = CONFIG, cache: FrameCache | None = None) -> SampleDataset:
    return SampleDataset(source, plan_windows(source, [0, 1], config), config, cache)


def equal(a: Sample, b: Sample) -> bool:
    return all(torch.equal(x, y) for x, y in zip(a, b, strict=True))


def test_a_sample_holds_its_row() -> None:
    source = SyntheticSource(SMALL)
    sample = samples(source)[40]
    row = int(sample.row)
    assert row == 40
    assert np.array_equal(sample.image.permute(1, 2, 0).numpy(), source.image(row))
    assert np.array_equal(sample.points.numpy(), source.points(row))
    assert int(sample.point_count) == 400
    assert np.array_equal(sample.velocity.numpy(), source.column("observation.state")[35:41])
    assert np.array_equal(sample.target.numpy(), source.column("label.outcome")[40:50].astype(np.float32))
    assert sample.reliability.tolist() == [
        source.column("observation.reliability.image")[row],
        source.column("observation.reliability.cloud")[row],
    ]


def test_the_trajectory_is_that_of_the_rows_velocity() -> None:
    source = SyntheticSource(SMALL)
    sample = samples(source)[40]
    calibration = source.calibration(1)
    assert calibration.camera is not None
    assert calibration.base_camera is not None
    expected = trajectory_image(
        source.column("observation.state")[40].astype(np.float32),
        calibration.camera,
        calibration.base_camera,
        TrajectoryImageConfig(robot_width_m=0.5, horizon=10, dt_s=0.1),
        height=24,
        width=32,
    )
    assert expected.any()
    assert np.array_equal(sample.trajectory[0].numpy(), expected)
    wide = samples(source, DataConfig(history_steps=6, robot_width_m=2.0))[40]
    assert wide.trajectory.count_nonzero() > sample.trajectory.count_nonzero()


def test_the_cache_changes_nothing_and_holds_what_fits() -> None:
    source = SyntheticSource(SyntheticConfig(rows=30))  # 225 KiB an image
    plain = samples(source)
    cache = FrameCache(source, plain.windows.row.tolist(), 2)
    assert len(cache) == 9
    held = samples(source, cache=cache)
    assert all(equal(plain[i], held[i]) for i in (0, 8, 9, 59))
    assert len(FrameCache(source, plain.windows.row.tolist(), 0)) == 0
    assert len(FrameCache(source, [], 2)) == 0


def test_a_missing_modality_is_blank_and_unreliable() -> None:
    source = SyntheticSource(SMALL)
    source.columns["valid.image"] = np.arange(len(source)) != 7
    source.columns["valid.lidar"] = np.arange(len(source)) != 8
    dataset = samples(source, DataConfig(history_steps=6, missing_modality=MissingModality.blank))
    no_image, no_cloud, whole = dataset[7], dataset[8], dataset[9]
    assert not no_image.image.any()
    assert no_image.reliability[0] == 0.0
    assert no_image.reliability[1] > 0.0
    assert not no_cloud.points.any()
    assert int(no_cloud.point_count) == 0
    assert no_cloud.reliability[1] == 0.0
    assert [tensor.shape for tensor in no_image] == [tensor.shape for tensor in no_cloud] == [t.shape for t in whole]


def test_samples_survive_pickling() -> None:
    dataset = samples(SyntheticSource(SMALL))
    copy: SampleDataset = pickle.loads(pickle.dumps(dataset))  # noqa: S301 (our own bytes)
    assert equal(dataset[3], copy[3])
