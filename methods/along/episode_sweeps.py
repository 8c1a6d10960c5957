"""Sweeps of an episode of a data set, from its whole clouds."""

from collections.abc import Iterator
from functools import partial

import numpy as np

from navtool.base.errors import DatasetsError
from navtool.datasets.store.reader import NavDataset
from navtool.datasets.store.whole_clouds import WholeCloud
from navtool.datasets.streams.motion import Motion
from navtool.methods.along.sweeps import Pending, SweepConfig, SweepSource

_CURE = "ingest its recording again with the LiDAR's topic in robot.topics.lidar"
_UNSET_NORM = 1e-6


class EpisodeSweeps(SweepSource):
    """The sweeps of an episode.

    Args:
        dataset: Which it belongs to.
        episode: Its number.
        config: What becomes of a cloud.

    Raises:
        DatasetsError: There is no such episode, it has no clouds, or its files are damaged.
    """

    def __init__(self, dataset: NavDataset, episode: int, config: SweepConfig) -> None:
        if not 0 <= episode < len(dataset.episodes):
            what = f"there is no episode {episode}: the data set has {len(dataset.episodes)}, counted from 0"
            raise DatasetsError(what, where=dataset.root, cure="choose one with --episode")
        topic = dataset.provenance()[episode].get("topics", {}).get("lidar", "lidar")
        calibration = dataset.calibration(episode)
        motion = _motion(dataset, episode, config.odometry_gap_s)
        super().__init__(dataset.episodes[episode].source, str(topic), calibration, motion, config)
        self._dataset, self._episode = dataset, episode
        stamps_ns = dataset.cloud_stamps(episode)
        if not stamps_ns.size:
            raise DatasetsError(f"episode {episode} has no whole clouds", where=dataset.root, cure=_CURE)
        self.clouds, self.duration_s = stamps_ns.size, float(np.ptp(stamps_ns)) * 1e-9

    def _pending(self) -> Iterator[Pending]:
        for cloud in self._dataset.clouds(self._episode):
            yield Pending(cloud.stamp_ns, partial(_itself, cloud))


def _itself(cloud: WholeCloud) -> WholeCloud:
    return cloud


def _motion(dataset: NavDataset, episode: int, max_gap_s: float) -> Motion | None:
    """The robot's way by the odometry beside the rows, which is that of the base frame already."""
    stream = dataset.stream(episode, "odometry")
    if stream is None or not stream["stamp_ns"].size:
        return None
    finite = np.isfinite(np.stack([values for name, values in stream.items() if not name.endswith("_ns")])).all(axis=0)
    position, attitude = (
        np.stack([stream[name][finite] for name in names], axis=1)
        for names in (("x_m", "y_m", "z_m"), ("qx", "qy", "qz", "qw"))
    )
    unset = np.linalg.norm(attitude, axis=1) < _UNSET_NORM
    attitude = np.where(unset[:, None], np.array([0.0, 0.0, 0.0, 1.0]), attitude)
    return Motion(stream["stamp_ns"][finite], position, attitude, max_gap_s)
