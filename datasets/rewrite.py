"""New label columns in a data set's files, all else kept."""

from collections.abc import Mapping
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq
from jaxtyping import Shaped

from navtool.datasets.errors import DatasetsError
from navtool.datasets.ingest.data_file import WRITER_OPTIONS, to_arrow
from navtool.datasets.ingest.stats import Stats
from navtool.pipeline.arrays import Array


def rewrite_columns(source: Path, out: Path, columns: Mapping[str, Shaped[Array, "rows *shape"]]) -> None:
    """Write a data file again with some columns replaced, one row group at a time.

    Schema with its metadata, row groups, compression and every other value stay; the same input gives the same bytes.

    Args:
        source: A data file.
        out: Where to write; an existing file is replaced.
        columns: Values of all rows, by column name.
    """
    with _opened(source) as file, pq.ParquetWriter(out, file.schema_arrow, **WRITER_OPTIONS) as writer:
        schema: pa.Schema = file.schema_arrow
        first = 0
        for group in range(file.num_row_groups):
            table = _read_group(file, group, source)
            rows = slice(first, first + table.num_rows)
            for name, values in columns.items():
                place = schema.get_field_index(name)
                table = table.set_column(place, schema.field(place), to_arrow(values[rows], schema.field(place).type))
            writer.write_table(table, row_group_size=table.num_rows)
            first = rows.stop


def _opened(source: Path) -> pq.ParquetFile:
    try:
        return pq.ParquetFile(source)
    except (OSError, pa.ArrowException) as error:
        raise _damaged(source, error) from error


def _read_group(file: pq.ParquetFile, group: int, source: Path) -> pa.Table:
    try:
        return file.read_row_group(group, use_threads=False)
    except (OSError, pa.ArrowException) as error:
        raise _damaged(source, error) from error


def _damaged(source: Path, error: Exception) -> DatasetsError:
    first = str(error).partition("\n")[0]
    return DatasetsError(f"cannot be read ({first})", where=source, cure="run `navtool check` on the data set")


def rewrite_stats(source: Path, out: Path, stats: Mapping[str, Stats]) -> None:
    """Write an episode's metadata again with the statistics of some columns replaced."""
    table = pq.read_table(source)
    for key, of_column in stats.items():
        for name, value in of_column.items():
            place = table.schema.get_field_index(f"stats/{key}/{name}")
            field = table.schema.field(place)
            table = table.set_column(place, field, pa.array([value], type=field.type))
    pq.write_table(table, out)
