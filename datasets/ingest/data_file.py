"""The Parquet file that holds an episode's rows."""

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from jaxtyping import Float32

from navtool.datasets.ingest.columns import Column
from navtool.datasets.schema import CLOUD_SIZE, POINTS_KEY, Feature, arrow_schema
from navtool.pipeline.arrays import Array

ROWS_PER_GROUP = 4
"""Rows a row group where there are clouds: reading one cloud at random decodes half a megabyte."""
ROWS_PER_GROUP_SMALL = 1000
"""Rows a row group where there are none."""


def write_data(
    path: Path,
    features: Mapping[str, Feature],
    columns: Mapping[str, Column],
    points: Iterable[Float32[Array, "rows 10000 3"]],
) -> None:
    """Write an episode's data file.

    Args:
        columns: The whole columns, clouds apart.
        points: The clouds, in pieces of any number of row groups; as many rows in all as the columns have. Empty where
            the data set has none.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    schema = arrow_schema(features)
    with pq.ParquetWriter(path, schema, **WRITER_OPTIONS) as writer:
        for rows, clouds in _row_groups(columns, points, clouds=POINTS_KEY in features):
            arrays = [
                _cloud_array(clouds)
                if clouds is not None and field.name == POINTS_KEY
                else to_arrow(columns[field.name][rows], field.type)
                for field in schema
            ]
            writer.write_table(pa.Table.from_arrays(arrays, schema=schema))


def _row_groups(
    columns: Mapping[str, Column], points: Iterable[Float32[Array, "rows 10000 3"]], *, clouds: bool
) -> Iterator[tuple[slice, Float32[Array, "rows 10000 3"] | None]]:
    """The rows of each group, with their clouds."""
    if not clouds:
        total = len(columns["index"])
        yield from (
            (slice(first, first + ROWS_PER_GROUP_SMALL), None) for first in range(0, total, ROWS_PER_GROUP_SMALL)
        )
        return
    done = 0
    for piece in points:
        for first in range(0, len(piece), ROWS_PER_GROUP):
            group = piece[first : first + ROWS_PER_GROUP]
            yield slice(done, done + len(group)), group
            done += len(group)


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
    flat = pa.Array.from_buffers(pa.float32(), points.size, [None, pa.py_buffer(np.ascontiguousarray(points))])
    inner = pa.ListArray.from_arrays(pa.array(np.arange(0, rows * CLOUD_SIZE * 3 + 1, 3, dtype=np.int32)), flat)
    return pa.ListArray.from_arrays(pa.array(np.arange(rows + 1, dtype=np.int32) * CLOUD_SIZE), inner)
