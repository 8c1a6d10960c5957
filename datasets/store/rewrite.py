"""New values in a data set's files, all else kept."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from jaxtyping import Shaped

from navtool.base.errors import DatasetsError
from navtool.base.files import parquet_bytes, write_bytes
from navtool.datasets.store.arrow_arrays import nested_array, number_array, text_array
from navtool.datasets.store.data_file import WRITER_OPTIONS, to_arrow
from navtool.datasets.store.stats import Stats
from navtool.pipeline.arrays import Array


def rewrite_columns(
    source: Path, out: Path, schema: pa.Schema, columns: Mapping[str, Shaped[Array, " rows *shape"]]
) -> None:
    """Write a data file again with some columns replaced, one row group at a time.

    Row groups, compression and every other value stay: the bytes are those that ingest would have written.

    Args:
        source: A data file.
        out: Where to write; an existing file is replaced.
        schema: The data set's; the one read back from a file is equal, but not to the bit.
        columns: Values of all rows, by column name.
    """
    with _opened(source) as file, pq.ParquetWriter(out, schema, **WRITER_OPTIONS) as writer:
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


def rewrite_entry(source: Path, out: Path, changes: Mapping[str, object]) -> None:
    """Write an episode's entry again with some of its values replaced, by column name."""
    entry = pq.read_table(source).to_pylist()[0]
    if unknown := sorted(set(changes) - set(entry)):
        raise DatasetsError(f"has no {', '.join(unknown)}", where=source, cure="ingest the recording again")
    write_bytes(out, parquet_bytes(entry_table(entry | dict(changes))))


def entry_table(entry: Mapping[str, object]) -> pa.Table:
    """An episode's entry as a table of one row: numbers, nested lists of numbers, lists of names."""
    return pa.Table.from_arrays([_entry_column(value) for value in entry.values()], names=list(entry))


def _entry_column(value: object) -> pa.Array:
    if isinstance(value, list) and value and isinstance(value[0], str):
        return pa.ListArray.from_arrays(number_array(np.array([0, len(value)], dtype=np.int32)), text_array(value))
    return nested_array(np.array([value]))


def stats_columns(stats: Mapping[str, Stats]) -> dict[str, object]:
    """The statistics of some columns as an episode's entry names them."""
    return {f"stats/{key}/{name}": value for key, of_column in stats.items() for name, value in of_column.items()}
