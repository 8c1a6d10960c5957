"""The Parquet file that holds an episode's rows."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from jaxtyping import Shaped

from navtool.datasets.store.arrow_arrays import number_array, text_array
from navtool.datasets.store.schema import Feature, arrow_schema
from navtool.pipeline.arrays import Array

ROWS_PER_GROUP = 1000

type Column = Shaped[Array, " ticks *shape"]


def write_data(path: Path, features: Mapping[str, Feature], columns: Mapping[str, Column]) -> None:
    """Write an episode's data file."""
    path.parent.mkdir(parents=True, exist_ok=True)
    schema = arrow_schema(features)
    table = pa.Table.from_arrays([to_arrow(columns[field.name], field.type) for field in schema], schema=schema)
    with pq.ParquetWriter(path, schema, **WRITER_OPTIONS) as writer:
        writer.write_table(table, row_group_size=ROWS_PER_GROUP)


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
