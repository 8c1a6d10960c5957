"""The rows' clouds of fixed size, beside the rows: one at a time, at random, without their repeated points."""

from pathlib import Path
from types import TracebackType

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from jaxtyping import Float32

from navtool.datasets.store.schema import CLOUD_SIZE
from navtool.pipeline.arrays import Array

ROWS_PER_PART = 512
"""Rows of an episode whose points lie in one file; of the last file fewer."""
POINTS_SCHEMA = pa.schema([pa.field("xyz_mm", pa.binary())])
"""One row a row of the data set, each a row group of its own, so that a random one costs no other.

The bytes are a little-endian int32 array of x, y and z, one point after the other. As whole millimetres, which they
are, they take two thirds of the space of float32; as lists of numbers they would take ten times as long to read.
"""
_MM_PER_M = np.float32(1000.0)


def points_part(folder: Path, part: int) -> Path:
    """A file of the rows' points in their folder, by its number."""
    return folder / f"part-{part:05d}.parquet"


class PointsFile:
    """Writes the points of rows one after the other; memory stays that of one row."""

    def __init__(self, path: Path) -> None:
        path.parent.mkdir(parents=True, exist_ok=True)
        self._writer = pq.ParquetWriter(
            path,
            POINTS_SCHEMA,
            compression="zstd",
            compression_level=1,
            use_dictionary=False,
            write_page_checksum=True,
            write_statistics=False,
        )

    def add(self, points: Float32[Array, "n 3"]) -> None:
        """Add the points of the next row: metres, rounded to 1 mm, at most 10000."""
        content = np.ascontiguousarray(np.rint(points * _MM_PER_M), "<i4")
        ends = np.array([0, content.nbytes], dtype=np.int32)
        blob = pa.Array.from_buffers(pa.binary(), 1, [None, pa.py_buffer(ends), pa.py_buffer(content)])
        self._writer.write_table(pa.Table.from_arrays([blob], schema=POINTS_SCHEMA))

    def __enter__(self) -> "PointsFile":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._writer.close()


def read_points(file: pq.ParquetFile, row: int) -> Float32[Array, "n 3"]:
    """The points of a row, counted from the file's first: metres; none where there is no cloud.

    Raises:
        ValueError: The file holds no such row, or something else than points.
    """
    if row >= file.num_row_groups:
        raise ValueError(f"holds points of {file.num_row_groups} rows")
    (blob,) = file.read_row_group(row, use_threads=False).column(0)
    points = np.frombuffer(blob.as_buffer(), "<i4").astype(np.float32).reshape(-1, 3)
    points /= _MM_PER_M
    return points


def of_fixed_size(points: Float32[Array, "n 3"]) -> Float32[Array, "10000 3"]:
    """The points repeated, from the first one on, up to the number that networks read; zeros where there are none."""
    return points if len(points) == CLOUD_SIZE else np.resize(points, (CLOUD_SIZE, 3))
