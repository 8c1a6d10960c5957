"""LiDAR clouds on their way into a segment's rows and into the file of whole clouds."""

import numpy as np
from jaxtyping import Float32

from navtool.base.background import Background
from navtool.datasets.decode.messages import Decoded, PointCloud
from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.ingest.lane import Lane
from navtool.datasets.ingest.segment import Segment
from navtool.datasets.recording import RawMessage
from navtool.datasets.store.row_points import PointsFile
from navtool.datasets.store.schema import CLOUD_RELIABILITY_KEYS, CLOUD_SIZE, COUNT_KEY
from navtool.datasets.store.sidecar import CloudFile
from navtool.pipeline.arrays import Array
from navtool.pipeline.cloud_reliability import cloud_reliability
from navtool.pipeline.downsample import fixed_size_cloud

type Points = Float32[Array, "n 3"]

_NO_POINTS: Points = np.zeros((0, 3), dtype=np.float32)


class LidarLane(Lane):
    """Keeps clouds whole, judges them as they were recorded, and thins them in the base frame for the rows.

    All clouds are compressed and written in the thread beside. Where the rows have no clouds, ``points`` is None and
    they are kept whole alone.
    """

    def __init__(
        self,
        stream: str,
        segment: Segment,
        points: PointsFile | None,
        clouds: CloudFile | None,
        config: IngestConfig,
        beside: Background,
    ) -> None:
        super().__init__(stream, segment.parts.get(stream), segment.ticks, CLOUD_RELIABILITY_KEYS)
        self.points_nonfinite = 0
        self.not_deskewed = 0
        self._segment, self._config = segment, config
        self._file, self._clouds, self._beside = points, clouds, beside
        self._counts = np.zeros(segment.ticks, dtype=np.int64)
        self._thinned: dict[int, Points] = {}

    def finish(self) -> None:
        """Write what is left; ticks whose cloud never came have none."""
        super().finish()
        self.columns[COUNT_KEY] = self._counts

    def _wanted(self, position: int) -> bool:
        return position in self._part.own

    def _use(self, sample: Decoded, ticks: list[int], raw: RawMessage, position: int) -> None:
        if not isinstance(sample, PointCloud):
            raise TypeError(f"{type(sample).__name__} is no cloud")
        stamp_ns = self._part.stamps_ns[position]
        if position in self._part.own and self._clouds is not None:
            self.points_nonfinite += sample.dropped_nonfinite
            serves = self._segment.first_tick + ticks[0] if ticks else -1
            self._beside.call(self._clouds.add, sample, stamp_ns, raw.record_ns, serves)
        if ticks and self._file is not None:
            self._set_reliability(ticks, cloud_reliability(sample.xyz, sample.ring, self._config.cloud_reliability))
            points = self._in_base_frame(sample, stamp_ns)
            self._counts[ticks] = len(points)
            for tick in ticks:
                self._thinned[tick] = points

    def _write(self, tick: int) -> None:
        if self._file is not None:
            self._beside.call(self._file.add, self._thinned.pop(tick, _NO_POINTS))

    def _in_base_frame(self, cloud: PointCloud, stamp_ns: int) -> Points:
        columns = np.ascontiguousarray(cloud.xyz.T)
        time_s = cloud.time_s
        x, y, z = columns
        returned = (x != 0) | (y != 0) | (z != 0)
        if not returned.all():
            columns = columns.compress(returned, axis=1)
            time_s = None if time_s is None else time_s[returned]
        pose = self._segment.base_lidar
        if pose is not None:
            columns = pose[:3, :3].astype(np.float32) @ columns + pose[:3, 3:].astype(np.float32)
        if self._config.deskew:
            columns = self._deskewed(columns, time_s, stamp_ns)
        points, kept = fixed_size_cloud(columns.T, CLOUD_SIZE, stamp_ns, self._config.voxel_m)
        return points[:kept]

    def _deskewed(
        self, columns: Float32[Array, "3 n"], time_s: Float32[Array, " n"] | None, stamp_ns: int
    ) -> Float32[Array, "3 n"]:
        motion = self._segment.motion
        if time_s is not None and motion is not None and time_s.size:
            moved = motion.deskewed(columns, time_s, stamp_ns)
            if moved is not None:
                return moved
        self.not_deskewed += 1
        return columns
