"""Arrow arrays made without pandas are those that pyarrow makes itself."""

import subprocess
import sys

import numpy as np
import pyarrow as pa
import pytest
from hypothesis import given
from hypothesis import strategies as st

from navtool.datasets.store.arrow_arrays import nested_array, number_array, text_array
from navtool.datasets.store.rewrite import entry_table


@pytest.mark.parametrize("kind", ["bool", "uint16", "int32", "int64", "float32", "float64"])
def test_numbers(kind: str) -> None:
    values = np.random.default_rng(0).integers(0, 2, 21).astype(kind)
    for part in (values, values[::2], values[:0]):
        assert number_array(part).equals(pa.array(part))


@given(st.lists(st.text()))
def test_texts(values: list[str]) -> None:
    assert text_array(values).equals(pa.array(values, pa.string()))


@given(st.lists(st.integers(0, 4), min_size=1, max_size=4))
def test_nested_lists(shape: list[int]) -> None:
    values = np.arange(float(np.prod(shape))).reshape(shape)
    if 0 not in shape:
        assert nested_array(values).equals(pa.array(values.tolist()))
    assert nested_array(values).to_pylist() == values.tolist()


def test_an_entry_is_the_table_of_its_values() -> None:
    entry = {"length": 3, "at": 0.5, "tasks": ["walk", "stehn"], "stats/x/mean": [[[0.1]], [[0.2]]], "count": [7]}
    table, usual = entry_table(entry), pa.Table.from_pylist([entry])
    assert table.schema.equals(usual.schema)
    assert table.equals(usual)


def test_no_pandas_is_imported() -> None:
    code = (
        "import sys, numpy as np; from navtool.datasets.store.rewrite import entry_table; "
        "from navtool.base.files import parquet_bytes; "
        "parquet_bytes(entry_table({'a': [1.0], 't': ['x']})); print('pandas' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)  # noqa: S603
    assert done.stdout.strip() == "False"
