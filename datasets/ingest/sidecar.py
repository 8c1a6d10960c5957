"""What LeRobot's columns cannot hold, stored beside them: full clouds and streams at their own rates."""

from collections.abc import Mapping
from pathlib import Path
from types import TracebackType

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from jaxtyping import Float64

from navtool.datasets.decode.messages import PointCloud
from navtool.datasets.ingest.columns import TimedStream
from navtool.datasets.ingest.rows import IMU_COLUMNS
from navtool.pipeline.arrays import Array
from navtool.pipeline.geometry.transforms import apply_transform

CLOUDS_PER_GROUP = 32
CLOUD_SCHEMA = pa.schema(
    [
        pa.field("stamp_ns", pa.int64()),
        pa.field("record_ns", pa.int64()),
        pa.field("frame_index", pa.int64()),
        pa.field("xyz_m", pa.list_(pa.float32())),
        pa.field("intensity", pa.list_(pa.float32())),
        pa.field("ring", pa.list_(pa.uint16())),
        pa.field("time_s", pa.list_(pa.float32())),
    ]
)
"""One row a cloud, in the order of record and in the sensor's frame: x, y, z interleaved; null where not recorded;
``frame_index`` is the first row it serves, -1 for none."""


class CloudFile:
    """Writes every cloud of a recording, whole, in row groups of 32; memory stays that of one group."""

    def __init__(self, path: Path) -> None:
        path.parent.mkdir(parents=True, exist_ok=True)
        self._writer = pq.ParquetWriter(
            path, CLOUD_SCHEMA, compression="zstd", compression_level=1, use_dictionary=False
        )
        self._rows: list[dict[str, object]] = []

    def add(self, cloud: PointCloud, stamp_ns: int, record_ns: int, frame_index: int) -> None:
        """Add one cloud."""
        self._rows.append(
            {
                "stamp_ns": stamp_ns,
                "record_ns": record_ns,
                "frame_index": frame_index,
                "xyz_m": np.ascontiguousarray(cloud.xyz).reshape(-1),
                "intensity": cloud.intensity,
                "ring": cloud.ring,
                "time_s": cloud.time_s,
            }
        )
        if len(self._rows) == CLOUDS_PER_GROUP:
            self._flush()

    def _flush(self) -> None:
        if self._rows:
            columns = [pa.array([row[field.name] for row in self._rows], type=field.type) for field in CLOUD_SCHEMA]
            self._writer.write_table(pa.Table.from_arrays(columns, schema=CLOUD_SCHEMA))
            self._rows.clear()

    def __enter__(self) -> "CloudFile":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if kind is None:
            self._flush()
        self._writer.close()


def write_streams(folder: Path, streams: Mapping[str, TimedStream], base_imu: Float64[Array, "4 4"] | None) -> None:
    """Write each small stream with its true stamps, one file a stream, in the order of time.

    Values stay as recorded, NaN included; only the IMU is turned into the base frame's axes where its pose is known.
    """
    folder.mkdir(parents=True, exist_ok=True)
    for name, stream in streams.items():
        values = in_base_axes(stream, base_imu).values if name == "imu" else stream.values
        record_ns = np.array(stream.scan.record_ns, dtype=np.int64)[stream.time.order]
        table = pa.table(
            {
                "stamp_ns": stream.time.stamps_ns,
                "record_ns": record_ns,
                **{column: values[:, place] for place, column in enumerate(stream.scan.columns)},
            }
        )
        pq.write_table(table, folder / f"{name}.parquet", compression="zstd")


def in_base_axes(imu: TimedStream, base_imu: Float64[Array, "4 4"] | None) -> TimedStream:
    """The IMU's accelerations and angular velocities in the base frame's axes; as recorded without a pose.

    Only turned, not moved: a lever arm's accelerations stay in.
    """
    if base_imu is None or imu.scan.columns != IMU_COLUMNS:
        return imu
    turn = base_imu.copy()
    turn[:3, 3] = 0.0
    turned = np.hstack([apply_transform(turn, imu.values[:, :3]), apply_transform(turn, imu.values[:, 3:])])
    return TimedStream(imu.scan, imu.time, turned)
