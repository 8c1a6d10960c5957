"""Clouds as they were recorded, read back from beside the rows."""

from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
from jaxtyping import Float32, Int64, Shaped, UInt16

from navtool.pipeline.arrays import Array


@dataclass(frozen=True, slots=True)
class WholeCloud:
    """A cloud with all its points, in the sensor's frame and in the order of record.

    Attributes:
        stamp_ns: Its time on the clock of the grid.
        record_ns: When it was recorded.
        frame_index: The first row of its episode that it serves; -1 where it serves none.
        xyz: Metres.
        intensity: In the sensor's own scale; None where it was not recorded.
        ring: Index of the laser; None where it was not recorded.
        time_s: Seconds from the header's stamp; None where it was not recorded.
    """

    stamp_ns: int
    record_ns: int
    frame_index: int
    xyz: Float32[Array, "n 3"]
    intensity: Float32[Array, " n"] | None
    ring: UInt16[Array, " n"] | None
    time_s: Float32[Array, " n"] | None


def whole_cloud_stamps(folder: Path) -> Int64[Array, " clouds"]:
    """The times of an episode's clouds in the order of record, on the clock of the grid."""
    parts = [pq.read_table(part, columns=["stamp_ns"]).column(0).to_numpy() for part in sorted(folder.glob("part-*"))]
    return np.concatenate([np.zeros(0, np.int64), *parts])


class WholeClouds:
    """The clouds of an episode by the rows that they serve."""

    def __init__(self, folder: Path) -> None:
        self._parts = sorted(folder.glob("part-*.parquet"))
        first: list[tuple[int, int, int]] = []
        for part, path in enumerate(self._parts):
            served = pq.read_table(path, columns=["frame_index"]).column(0).to_pylist()
            first += [(row, part, position) for position, row in enumerate(served) if row >= 0]
        self._first = sorted(first)

    def of_row(self, row: int) -> WholeCloud | None:
        """The cloud that serves a row of the episode; None where none does."""
        place = bisect_right(self._first, row, key=lambda served: served[0]) - 1
        if place < 0:
            return None
        _, part, position = self._first[place]
        with pq.ParquetFile(self._parts[part], memory_map=True) as file:
            group, within = divmod(position, file.metadata.row_group(0).num_rows)
            table = file.read_row_group(group, use_threads=False).slice(within, 1)
            return _cloud(table.to_pylist()[0])


def read_whole_clouds(folder: Path, *, verify: bool = False) -> Iterator[WholeCloud]:
    """The clouds of an episode in the order of record, in the memory of one row group.

    Args:
        verify: Whether the pages' checksums are compared.
    """
    for part in sorted(folder.glob("part-*.parquet")):
        with pq.ParquetFile(part, page_checksum_verification=verify) as file:
            for group in range(file.num_row_groups):
                for row in file.read_row_group(group, use_threads=False).to_pylist():
                    yield _cloud(row)


def _cloud(row: dict[str, Any]) -> WholeCloud:
    return WholeCloud(
        stamp_ns=row["stamp_ns"],
        record_ns=row["record_ns"],
        frame_index=row["frame_index"],
        xyz=np.frombuffer(row["xyz_m"], "<f4").reshape(3, -1).T,
        intensity=_array(row["intensity"], "<f4"),
        ring=_array(row["ring"], "<u2"),
        time_s=_array(row["time_s"], "<f4"),
    )


def _array(content: bytes | None, dtype: str) -> Shaped[Array, " n"] | None:
    return None if content is None else np.frombuffer(content, dtype)
