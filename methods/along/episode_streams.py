"""The streams of an episode of a data set."""

from collections.abc import Iterator, Sequence
from functools import partial

import numpy as np
from jaxtyping import Int64

from navtool.base.errors import DatasetsError
from navtool.datasets.store.reader import NavDataset
from navtool.datasets.store.whole_clouds import WholeCloud
from navtool.datasets.streams.rows import ODOMETRY_COLUMNS
from navtool.methods.along.odometry_table import OdometryTable
from navtool.methods.along.streams import Cloud, Streams
from navtool.pipeline.arrays import Array

_MISSING = {"lidar": ("whole clouds", "LiDAR"), "odometry": ("odometry", "odometry")}
"""What an episode lacks without a stream, and whose topic its recording has to be ingested with."""


class EpisodeStreams(Streams):
    """The streams of an episode, which are on one clock and in the base frame's axes already.

    Args:
        dataset: Which it belongs to.
        episode: Its number, which is one of the data set's.
        reads: The streams that are wanted; the first has to be there.
        odometry_gap_s: Poses further apart than this are not interpolated between.

    Raises:
        DatasetsError: The first stream is not there, or the episode's files are damaged.
    """

    def __init__(self, dataset: NavDataset, episode: int, reads: Sequence[str], odometry_gap_s: float) -> None:
        recorded = dataset.provenance_of(episode).get("topics", {})
        topics = {name: str(recorded.get(name, name)) for name in reads}
        odometry = _odometry(dataset, episode) if "odometry" in reads else None
        self._stamps_ns = dataset.cloud_stamps(episode) if "lidar" in reads else np.zeros(0, np.int64)
        there = {"lidar": self._stamps_ns.size > 0, "odometry": odometry is not None}
        if not there[reads[0]]:
            what, sensor = _MISSING[reads[0]]
            cure = f"ingest its recording again with the {sensor}'s topic in robot.topics.{reads[0]}"
            raise DatasetsError(f"episode {episode} has no {what}", where=dataset.root, cure=cure)
        super().__init__(
            dataset.episodes[episode].source, topics, dataset.calibration(episode), odometry, odometry_gap_s
        )
        self._dataset, self._episode = dataset, episode

    @property
    def cloud_stamps_ns(self) -> Int64[Array, " clouds"]:
        """When each whole cloud was measured."""
        return self._stamps_ns

    def clouds(self) -> Iterator[Cloud]:
        """The whole clouds."""
        for cloud in self._dataset.clouds(self._episode):
            yield Cloud(cloud.stamp_ns, partial(_itself, cloud))


def _itself(cloud: WholeCloud) -> WholeCloud:
    return cloud


def _odometry(dataset: NavDataset, episode: int) -> OdometryTable | None:
    stream = dataset.stream(episode, "odometry")
    if stream is None or not stream["stamp_ns"].size or not set(ODOMETRY_COLUMNS) <= set(stream):
        return None
    values = np.stack([stream[name] for name in ODOMETRY_COLUMNS], axis=1).astype(np.float64)
    return OdometryTable(stream["stamp_ns"], values)
