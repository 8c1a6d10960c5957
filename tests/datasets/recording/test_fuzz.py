"""Damaged copies of small recordings: reading them ends, in time, memory and nothing but a `DatasetsError`."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from damage import copies, in_limits, read

CONTAINERS = ("ros1", "ros1_bz2", "ros1_lz4", "db3", "mcap", "mcap_zstd", "mcap_lz4", "mcap_small_chunks")


@pytest.mark.parametrize("number", [12, pytest.param(300, marks=pytest.mark.slow)])
@pytest.mark.parametrize("container", CONTAINERS)
def test_no_damage_ends_in_anything_but_messages_or_one_clear_error(
    container: str, number: int, write_recording: Callable[..., Path], drive_entries: Callable[..., Any], tmp_path: Path
) -> None:
    path = write_recording(container, drive_entries(1.0, ros1=container.startswith("ros1")))
    file = path if path.is_file() else next(x for x in path.iterdir() if x.name != "metadata.yaml")
    folder = tmp_path / "copies"
    folder.mkdir()
    paths = list(copies(file, folder, number))
    told = [read(copy) for copy in paths] if number == 12 else in_limits(read, [(copy,) for copy in paths])
    assert any(outcome not in (read(file), "0") for outcome in told), "the damage does something"
    assert not any("Memory" in outcome for outcome in told), told
