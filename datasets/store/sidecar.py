"""What LeRobot's columns cannot hold, stored beside them: full clouds and streams at their own rates."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from types import TracebackType

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from jaxtyping import Shaped

from navtool.datasets.decode.messages import PointCloud
from navtool.datasets.store.arrow_arrays import number_array
from navtool.datasets.streams.timed_stream import TimedStream
from navtool.pipeline.arrays import Array

CLOUDS_PER_GROUP = 16
CLOUD_SCHEMA = pa.schema(
    [
        pa.field("stamp_ns", pa.int64()),
        pa.field("record_ns", pa.int64()),
        pa.field("frame_index", pa.int64()),
        pa.field("xyz_m", pa.binary()),
        pa.field("intensity", pa.binary()),
        pa.field("ring", pa.binary()),
        pa.field("time_s", pa.binary()),
    ]
)
"""One row a cloud, in the order of record and in the sensor's frame; ``frame_index`` is the first row it serves, -1 for
none. The points are the bytes of little-endian arrays: float32 x of all points, then y, then z; float32 intensity,
uint16 ring, float32 time; null where not recorded. As lists of numbers they take longer to write and to read.
LZ4, but for coordinates, of which it takes nothing away: with Zstandard's fastest level a VLP-16's clouds take a
seventh less space and three times as long to compress.
"""


class CloudFile:
    """Writes clouds whole, in row groups of 16; memory stays that of one group."""

    def __init__(self, path: Path) -> None:
        path.parent.mkdir(parents=True, exist_ok=True)
        self._writer = pq.ParquetWriter(
            path,
            CLOUD_SCHEMA,
            compression={name: "none" if name == "xyz_m" else "lz4" for name in CLOUD_SCHEMA.names},
            use_dictionary=False,
            write_page_checksum=True,
            write_statistics=["stamp_ns", "record_ns", "frame_index"],
        )
        self._numbers: list[tuple[int, int, int]] = []
        self._clouds: list[PointCloud] = []

    def add(self, cloud: PointCloud, stamp_ns: int, record_ns: int, frame_index: int) -> None:
        """Add one cloud."""
        self._numbers.append((stamp_ns, record_ns, frame_index))
        self._clouds.append(cloud)
        if len(self._clouds) == CLOUDS_PER_GROUP:
            self._flush()

    def _flush(self) -> None:
        if not self._clouds:
            return
        numbers = np.array(self._numbers, dtype=np.int64).T
        columns = [
            *(number_array(column) for column in numbers),
            _blobs([cloud.xyz.T for cloud in self._clouds], "<f4"),
            _blobs([cloud.intensity for cloud in self._clouds], "<f4"),
            _blobs([cloud.ring for cloud in self._clouds], "<u2"),
            _blobs([cloud.time_s for cloud in self._clouds], "<f4"),
        ]
        self._writer.write_table(pa.Table.from_arrays(columns, schema=CLOUD_SCHEMA))
        self._numbers.clear()
        self._clouds.clear()

    def __enter__(self) -> "CloudFile":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if kind is None:
            self._flush()
        self._writer.close()


def _blobs(parts: Sequence[Shaped[Array, "..."] | None], dtype: str) -> pa.BinaryArray:
    """The bytes of one array a cloud, null where there is None; copied once."""
    sizes = [0 if part is None else part.size * np.dtype(dtype).itemsize for part in parts]
    ends = np.cumsum([0, *sizes], dtype=np.int32)
    joined = np.empty(ends[-1], dtype=np.uint8)
    for part, first, end in zip(parts, ends[:-1], ends[1:], strict=True):
        if part is not None:
            joined[first:end].view(dtype).reshape(part.shape)[...] = part
    there = np.packbits([part is not None for part in parts], bitorder="little")
    return pa.Array.from_buffers(
        pa.binary(), len(parts), [pa.py_buffer(there), pa.py_buffer(ends), pa.py_buffer(joined)]
    )


def write_streams(folder: Path, streams: Mapping[str, TimedStream]) -> None:
    """Write each small stream with its true stamps, one file a stream, in the order of time; NaN stays NaN."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, stream in streams.items():
        record_ns = np.array(stream.recorded.record_ns, dtype=np.int64)[stream.time.order]
        columns = {"stamp_ns": stream.time.stamps_ns, "record_ns": record_ns}
        columns |= {column: stream.values[:, place] for place, column in enumerate(stream.recorded.columns)}
        arrays = [number_array(column) for column in columns.values()]
        table = pa.Table.from_arrays(arrays, names=list(columns))
        pq.write_table(table, folder / f"{name}.parquet", compression="zstd", write_page_checksum=True)
