"""What a sample holds, with and without a cache, in this process and in another."""

import pickle
from pathlib import Path

import numpy as np
import pytest
import torch

from navtool.datasets.store.reader import NavDataset
from navtool.pipeline.geometry.trajectory_image import TrajectoryImageConfig, trajectory_image
from navtool.train.success.row_cache import SampleCaches, fill_caches
from navtool.train.success.samples import Sample, SampleDataset
from navtool.train.success.windows import DataConfig, MissingModality, plan_windows
from navtool.train.synthetic import SyntheticConfig, SyntheticSource

SMALL = SyntheticConfig(rows=30, image_height=24, image_width=32)
CONFIG = DataConfig(history_steps=6)


def samples(source: SyntheticSource, config: DataConfig = CONFIG, caches: SampleCaches | None = None) -> SampleDataset:
    return SampleDataset(source, plan_windows(source, [0, 1], config), config, caches)


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
        source.column("reliability.camera")[row],
        source.column("reliability.cloud")[row],
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


def test_the_caches_change_nothing_and_hold_what_fits() -> None:
    source = SyntheticSource(SyntheticConfig(rows=30))  # 117 KiB a cloud, 225 KiB an image
    plain = samples(source)
    caches = fill_caches(source, plain.windows.row.tolist(), 9)
    assert (len(caches.clouds), len(caches.images)) == (60, 9)
    assert caches.clouds.nbytes + caches.images.nbytes <= 9 * 2**20
    held = samples(source, caches=caches)
    assert all(equal(plain[i], held[i]) for i in (0, 8, 9, 59))
    assert [len(cache) for cache in fill_caches(source, plain.windows.row.tolist(), 0)] == [0, 0]
    assert [len(cache) for cache in fill_caches(source, [], 9)] == [0, 0]
    assert [len(cache) for cache in fill_caches(source, plain.windows.row.tolist(), 1000)] == [60, 60]


def test_rows_without_a_modality_are_not_held() -> None:
    source = SyntheticSource(SMALL)
    source.columns["valid.camera"] = np.arange(len(source)) % 2 == 0
    del source.columns["valid.lidar"]
    assert [len(cache) for cache in fill_caches(source, list(range(10)), 10)] == [0, 5]


def test_a_missing_modality_is_blank_and_unreliable() -> None:
    source = SyntheticSource(SMALL)
    source.columns["valid.camera"] = np.arange(len(source)) != 7
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


def test_a_recorded_data_set_gives_the_windows_that_upstream_gives(labelled_dataset: Path) -> None:
    source = NavDataset(labelled_dataset)
    config = DataConfig()
    dataset = SampleDataset(source, plan_windows(source, [0, 2], config), config)
    state, outcome, known = (source.column(key) for key in ("observation.state", "label.outcome", "label.known"))
    for index in (0, 30, len(dataset) - 4):
        sample = dataset[index]
        row = int(sample.row)
        episode = source.episode_of(row)
        past = np.clip(np.arange(row - 49, row + 1), episode.start, None)  # as LeRobot's delta_timestamps clamp
        ahead = np.arange(row, row + 10)
        inside = ahead < episode.stop
        assert np.array_equal(sample.velocity.numpy(), state[past])
        assert np.array_equal(sample.known.numpy(), known[row] & inside)
        judged = sample.known.numpy()
        assert np.array_equal(sample.target.numpy()[judged], outcome[ahead[judged]])
        assert np.array_equal(sample.points.numpy(), source.points(row))
        assert np.array_equal(sample.image.permute(1, 2, 0).numpy(), source.image(row))
    assert sample.known.sum() < 10  # the last one reaches beyond its episode
    assert sample.trajectory.any() or not state[row].any()
    copy: SampleDataset = pickle.loads(pickle.dumps(dataset))  # noqa: S301 (our own bytes)
    assert equal(copy[7], dataset[7])


def test_trajectories_outside_the_picture_are_counted() -> None:
    source = SyntheticSource(SMALL)
    dataset = samples(source)
    drawn = [bool(dataset[index].trajectory.any()) for index in range(len(dataset))]
    moving = [bool(dataset[index].velocity[-1].abs().max() > 0.1) for index in range(len(dataset))]
    seen = [d for d, m in zip(drawn, moving, strict=True) if m]
    assert dataset.unseen_share(len(dataset)) == pytest.approx(1 - np.mean(seen))
    near = samples(source, DataConfig(history_steps=6, horizon_steps=1, robot_width_m=0.01))
    assert near.unseen_share() > dataset.unseen_share()
