"""What lies beside the rows: whole clouds and streams at their own rates, read to their ends."""

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from jaxtyping import Int64

from navtool.datasets.check.content import FROZEN_S
from navtool.datasets.check.findings import Findings, Severity, first_line, name_of, runs, short
from navtool.datasets.robot.gravity import odd_gravity
from navtool.datasets.store.reader import Episode, NavDataset
from navtool.datasets.streams.clock import StreamTime
from navtool.datasets.streams.odometry_twist import twist_apart
from navtool.datasets.streams.recorded_stream import RecordedStream
from navtool.datasets.streams.rows import JOINT_KINDS, ODOMETRY_COLUMNS
from navtool.datasets.streams.table import STREAMS
from navtool.datasets.streams.timed_stream import TimedStream
from navtool.pipeline.arrays import Array

_ACCELERATION = ("ax_mps2", "ay_mps2", "az_mps2")

_OPTIONAL = {"battery": ("voltage_v", "percentage")}
"""Columns of a stream that are NaN throughout where nothing measures them, as the message's definition says."""


def check_native(dataset: NavDataset) -> Findings:
    """Stamps increase, values are there and change, and every whole cloud can be read."""
    for episode in dataset.episodes:
        for path in sorted((dataset.layout.episode(episode.index) / "streams").glob("*.parquet")):
            try:
                table = pq.read_table(path, page_checksum_verification=True)
            except (OSError, pa.ArrowException) as error:
                yield Severity.FAIL, short(dataset, path), f"cannot be read: {first_line(error)}"
                continue
            where = short(dataset, path)
            if not _as_written(table.schema):
                yield Severity.FAIL, where, "columns differ from those that ingest writes"
                continue
            columns = {name: table.column(name).to_numpy() for name in table.column_names}
            stamps = columns.pop("stamp_ns")
            columns.pop("record_ns")
            if (np.diff(stamps) <= 0).any():
                yield Severity.FAIL, where, f"{int((np.diff(stamps) <= 0).sum())} true stamps do not increase"
            yield from _values(where, path.stem, stamps, columns)
        for lidar in (None, *dataset.description.contents.lidars):
            yield from _clouds(dataset, episode, lidar)


def _as_written(schema: pa.Schema) -> bool:
    """Whether there are stamps, and nothing but numbers beside them."""
    kinds = dict(zip(schema.names, schema.types, strict=True))
    stamps = [kinds.pop(name, None) for name in ("stamp_ns", "record_ns")]
    return stamps == [pa.int64()] * 2 and all(kind == pa.float64() for kind in kinds.values())


def _values(where: str, stream: str, stamps: Int64[Array, " n"], columns: dict[str, Array]) -> Findings:
    if not columns or stamps.size < 2:
        return
    shares = {name: _lacking(stream, name, columns) for name in columns}
    optional = _OPTIONAL.get(stream, ())
    told = {name: share for name, share in shares.items() if share > 0 and not (name in optional and share == 1.0)}
    if lacking := [f"{name} {share:.0%}" for name, share in told.items()]:
        yield Severity.WARN, where, f"NaN as recorded: {', '.join(lacking[:6])}{' and more' if lacking[6:] else ''}"
    if stream == "imu" and (odd := odd_gravity(np.column_stack([columns[name] for name in _ACCELERATION]))):
        yield Severity.WARN, where, odd
    if stream == "odometry" and tuple(columns) == ODOMETRY_COLUMNS:
        for note in twist_apart(_timed(stamps, columns)):
            yield Severity.WARN, where, note.text.removeprefix("odometry: ")
    if stream in STREAMS and STREAMS[stream].never_still:
        table = np.column_stack(list(columns.values()))
        same = np.concatenate([[False], (table[1:] == table[:-1]).all(axis=1)])
        longest = max(((stamps[end - 1] - stamps[first - 1]) * 1e-9 for first, end in runs(same)), default=0.0)
        if longest >= FROZEN_S:
            yield Severity.WARN, where, f"the measured values are frozen for {longest:.1f} s"


def _timed(stamps: Int64[Array, " n"], columns: dict[str, Array]) -> TimedStream:
    """A native stream as the first pass reads it."""
    rows = list(zip(*(values.tolist() for values in columns.values()), strict=True))
    recorded = RecordedStream("", rows=rows, columns=tuple(columns))
    return TimedStream.of(recorded, StreamTime(stamps, np.arange(stamps.size), "header"))


def _lacking(stream: str, name: str, columns: dict[str, Array]) -> float:
    """Share of a column's values that are NaN; a joint that a message does not name lacks none."""
    lacking = np.isnan(columns[name])
    if stream != "joints":
        return float(lacking.mean())
    joint = name.partition(".")[2]
    named = ~np.all([np.isnan(columns[f"{kind}.{joint}"]) for kind in JOINT_KINDS], axis=0)
    return float(lacking[named].mean()) if named.any() else 1.0


def _clouds(dataset: NavDataset, episode: Episode, lidar: str | None) -> Findings:
    """A LiDAR's whole clouds, one by one."""
    folder = dataset.layout.clouds(episode.index, lidar)
    if not folder.is_dir():
        return
    last, backwards, empty, count = -1, 0, 0, 0
    try:
        for cloud in dataset.clouds(episode.index, lidar):
            count += 1
            empty += int(not len(cloud.xyz))
            backwards += int(cloud.record_ns < last)
            last = cloud.record_ns
    except (OSError, ValueError, pa.ArrowException) as error:
        yield Severity.FAIL, short(dataset, folder), f"cannot be read: {first_line(error)}"
        return
    if backwards:
        yield Severity.FAIL, short(dataset, folder), f"{backwards} clouds are not in the order of record"
    if empty:
        yield (
            Severity.WARN,
            name_of(episode),
            f"{empty} of {count} whole clouds {f'of lidar.{lidar} ' if lidar else ''}have no points",
        )
