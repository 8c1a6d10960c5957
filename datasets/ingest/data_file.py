"""The Parquet file that holds an episode's rows."""

from collections.abc import Mapping
from pathlib import Path
from types import TracebackType

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from jaxtyping import Float32

from navtool.datasets.ingest.columns import Column
from navtool.datasets.schema import CLOUD_SIZE, POINTS_KEY, Feature, arrow_schema
from navtool.pipeline.arrays import Array

ROWS_PER_GROUP = 16
"""Rows a row group where there are clouds: reading one cloud at random decodes about 2 MB."""
ROWS_PER_GROUP_SMALL = 1000
"""Rows a row group where there are none."""


class DataFile:
    """Writes rows in the order of ticks, clouds streamed, the small columns taken from whole arrays.

    The columns are looked at when a row group is written: until then their values may still be filled in. Use it as a
    context manager; only leaving it without an error writes the footer of a complete file.
    """

    def __init__(self, path: Path, features: Mapping[str, Feature], columns: Mapping[str, Column]) -> None:
        path.parent.mkdir(parents=True, exist_ok=True)
        self._schema = arrow_schema(features)
        self._columns = columns
        self._group = ROWS_PER_GROUP if POINTS_KEY in features else ROWS_PER_GROUP_SMALL
        self._writer = pq.ParquetWriter(path, self._schema, **WRITER_OPTIONS)
        self._points: list[Float32[Array, "10000 3"] | None] = []
        self._first = 0

    def add(self, tick: int, points: Float32[Array, "10000 3"] | None) -> None:
        """Add the next row.

        Args:
            tick: Its number; must follow the last one.
            points: Its cloud; None where the data set has none.
        """
        if tick != self._first + len(self._points):
            raise ValueError(f"row {tick} does not follow row {self._first + len(self._points) - 1}")
        self._points.append(points)
        if len(self._points) == self._group:
            self._flush()

    def _flush(self) -> None:
        if not self._points:
            return
        rows = slice(self._first, self._first + len(self._points))
        arrays = [
            _cloud_array(np.stack([points for points in self._points if points is not None]))
            if field.name == POINTS_KEY
            else to_arrow(self._columns[field.name][rows], field.type)
            for field in self._schema
        ]
        self._writer.write_table(pa.Table.from_arrays(arrays, schema=self._schema))
        self._first += len(self._points)
        self._points.clear()

    def __enter__(self) -> "DataFile":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if kind is None:
            self._flush()
        self._writer.close()


WRITER_OPTIONS: dict[str, object] = {
    "compression": "zstd",
    "compression_level": 1,
    "use_dictionary": ["label.reason"],
    "write_statistics": False,
}
"""How data files are written, by ingest and by relabelling alike."""


def to_arrow(values: Column, kind: pa.DataType) -> pa.Array:
    """A column's rows as an Arrow array of the schema's type."""
    if pa.types.is_fixed_size_list(kind):
        flat = pa.array(np.ascontiguousarray(values).reshape(-1), type=kind.value_type)
        return pa.FixedSizeListArray.from_arrays(flat, type=kind)
    return pa.array(values, type=kind)


def _cloud_array(points: Float32[Array, "rows 10000 3"]) -> pa.ListArray:
    rows = len(points)
    inner = pa.ListArray.from_arrays(
        pa.array(np.arange(0, rows * CLOUD_SIZE * 3 + 1, 3, dtype=np.int32)), pa.array(points.reshape(-1))
    )
    return pa.ListArray.from_arrays(pa.array(np.arange(rows + 1, dtype=np.int32) * CLOUD_SIZE), inner)
