"""The Parquet file that holds an episode's rows."""

from collections.abc import Iterable, Mapping
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from jaxtyping import Float32, Shaped

from navtool.datasets.store.arrow_arrays import nested_array, number_array, text_array
from navtool.datasets.store.schema import POINTS_KEY, Feature, arrow_schema
from navtool.pipeline.arrays import Array

ROWS_PER_GROUP = 4
"""Rows a row group where there are clouds: reading one cloud at random decodes half a megabyte."""
ROWS_PER_GROUP_SMALL = 1000
"""Rows a row group where there are none."""

type Column = Shaped[Array, " ticks *shape"]


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
    rest = pa.schema([field for field in schema if field.name != POINTS_KEY])
    small = pa.Table.from_arrays([to_arrow(columns[field.name], field.type) for field in rest], schema=rest)
    place = schema.get_field_index(POINTS_KEY)
    with pq.ParquetWriter(path, schema, **WRITER_OPTIONS) as writer:
        if place == -1:
            writer.write_table(small, row_group_size=ROWS_PER_GROUP_SMALL)
            return
        done = 0
        for piece in points:
            for first in range(0, len(piece), ROWS_PER_GROUP):
                group = piece[first : first + ROWS_PER_GROUP]
                rows = small.slice(done, len(group))
                writer.write_table(rows.add_column(place, schema.field(place), nested_array(group)))
                done += len(group)


WRITER_OPTIONS: dict[str, object] = {
    "compression": "zstd",
    "compression_level": 1,
    "use_dictionary": ["label.reason"],
    "write_statistics": False,
    "write_page_checksum": True,
}
"""How data files are written, by ingest and by relabelling alike."""


def to_arrow(values: Column, kind: pa.DataType) -> pa.Array:
    """A column's rows as an Arrow array of the schema's type; a vector of one element becomes a plain value."""
    if pa.types.is_fixed_size_list(kind):
        return pa.FixedSizeListArray.from_arrays(number_array(np.ascontiguousarray(values).reshape(-1)), type=kind)
    return text_array(values.tolist()) if pa.types.is_string(kind) else number_array(values.reshape(-1))
