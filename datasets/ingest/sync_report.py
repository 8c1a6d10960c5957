"""What sync did with every stream: which clock, how regular, how far from the ticks, what is missing and where."""

from collections.abc import Mapping

import numpy as np
from jaxtyping import Float64, Int64

from navtool.base.note import Note
from navtool.base.plain import plain
from navtool.datasets.ingest.grid import Grid
from navtool.datasets.store.data_file import Column
from navtool.datasets.streams.clock import Jump, StreamTime
from navtool.datasets.streams.clocks import Clocks
from navtool.datasets.streams.config import StreamSync, SyncConfig
from navtool.datasets.streams.first_pass import FirstPass
from navtool.datasets.streams.measured_offsets import Measured
from navtool.datasets.streams.sync import Method
from navtool.datasets.streams.table import in_rows
from navtool.pipeline.arrays import Array

GAPS_SHOWN = 20
GAP_PERIODS = 3.0
"""An interval longer than so many usual ones is a gap."""
LATE_S = 1.0
"""A message recorded so much later than usual is late."""
_DRIFT_LEAST_S = 20.0


def sync_report(
    found: FirstPass,
    clocks: Clocks,
    grid: Grid,
    columns: Mapping[str, Column],
    config: SyncConfig,
    measured: Mapping[str, Measured],
    further: Mapping[str, list[Note]],
) -> dict[str, object]:
    """The content of ``sync.json``: the grid, and for each stream how it was brought onto it.

    Times within the recording are seconds from the grid's first tick.

    Args:
        further: What else is to be said of single streams.
    """
    streams, start_ns = {}, int(grid.ticks_ns[0])
    for name, time in grid.times.items():
        sync, column = config.of(name), in_rows(name)
        valid = columns.get(f"valid.{column}")
        errors = np.abs(columns[f"sync.error_s.{column}"][valid]) if valid is not None else np.zeros(0)
        header_ns, record_ns = clocks.as_recorded(name)
        streams[name] = {
            "topic": found.streams[name].topic,
            "messages": len(record_ns),
            "other_sources": found.streams[name].left_out,
            "clock": time.source,
            "method": _method(name, sync),
            "tolerance_s": None if sync is None else sync.tolerance_s,
            **_intervals(time.stamps_ns, start_ns),
            **_against_record(header_ns, record_ns),
            "clock_offset": _offset(clocks, name),
            "motion": _motion(measured.get(name)),
            "backwards": time.backwards,
            "repeated": time.repeated,
            "unstamped": time.unstamped,
            "undecodable": found.streams[name].undecodable,
            "clock_steps": [_step(jump, time, clocks.recorded_ns[name], start_ns) for jump in clocks.jumps[name]],
            "ticks_served": None if valid is None else int(valid.sum()),
            "error_median_s": _rounded(np.median(errors)) if errors.size else None,
            "error_max_s": _rounded(errors.max()) if errors.size else None,
            "notes": plain([*_notes(name, time, clocks), *further.get(name, [])]),
        }
    return {
        "grid_stream": grid.stream,
        "start_ns": start_ns,
        "end_ns": int(grid.ticks_ns[-1]),
        "ticks": int(grid.ticks_ns.size),
        "streams": streams,
    }


def time_notes(clocks: Clocks, grid: Grid) -> list[Note]:
    """What the report has to say of single streams, for a person."""
    return [note.about(name) for name, time in grid.times.items() for note in _notes(name, time, clocks)]


def _method(name: str, sync: StreamSync | None) -> str:
    if sync is None:
        return "kept at its own rate"
    slerp = name == "odometry" and sync.method is Method.linear
    return f"{sync.method}; slerp for the attitude" if slerp else str(sync.method)


def _intervals(stamps_ns: Int64[Array, " n"], start_ns: int) -> dict[str, object]:
    """Rate, jitter and gaps."""
    steps = np.diff(stamps_ns) * 1e-9
    if not steps.size:
        return {"rate_hz": None, "jitter_s": None, "gap_max_s": None, "gaps": [], "gaps_more": 0}
    usual = float(np.median(steps))
    wide = np.flatnonzero(steps > GAP_PERIODS * usual)
    longest = np.sort(wide[np.argsort(-steps[wide], kind="stable")][:GAPS_SHOWN])
    gaps = [
        {"at_s": _rounded((stamps_ns[i] - start_ns) * 1e-9), "length_s": _rounded(steps[i])} for i in longest.tolist()
    ]
    return {
        "rate_hz": round(1.0 / usual, 3),
        "jitter_s": _rounded(1.4826 * np.median(np.abs(steps - usual))),
        "gap_max_s": _rounded(steps.max()),
        "gaps": gaps,
        "gaps_more": int(wide.size - len(gaps)),
    }


def _against_record(header_ns: Int64[Array, " n"], record_ns: Int64[Array, " n"]) -> dict[str, object]:
    """The header clock against the recorder's: its offset, its drift, and how late messages were recorded."""
    stamped = header_ns > 0
    if not stamped.any():
        return {"header_minus_record_s": None, "drift_ppm": None, "latest_s": None}
    offset = header_ns[stamped] - record_ns[stamped]
    middle = int(np.median(offset))
    late = (middle - offset) * 1e-9
    return {
        "header_minus_record_s": _rounded(middle * 1e-9),
        "drift_ppm": _drift_ppm((offset - middle) * 1e-9, record_ns[stamped]),
        "latest_s": _rounded(late.max()),
    }


def _drift_ppm(offset_s: Float64[Array, " n"], record_ns: Int64[Array, " n"]) -> float | None:
    """Gain of the header clock on the recorder's in millionths; None where a recording is too short.

    Taken between the least delayed messages of the first and the last fifth: delays only ever push one way.
    """
    span_s = (int(record_ns[-1]) - int(record_ns[0])) * 1e-9
    fifth = offset_s.size // 5
    if span_s < _DRIFT_LEAST_S or fifth < 5:
        return None
    first, last = (float(np.quantile(part, 0.9)) for part in (offset_s[:fifth], offset_s[-fifth:]))
    return round((last - first) / (0.8 * span_s) * 1e6, 1)


def _offset(clocks: Clocks, name: str) -> dict[str, object] | None:
    """How far the header clock is ahead of the others', and what was added to its stamps; None where it is not."""
    offset = clocks.offsets.get(name)
    if offset is None:
        return None
    shift = offset.shift
    return {
        "ahead_s": _rounded(offset.apart_s),
        "added_s": 0.0 if shift is None else _rounded(shift.seconds),
        "added_drift_ppm": 0.0 if shift is None else round(shift.drift * 1e6, 1),
    }


def _motion(measured: Measured | None) -> dict[str, object] | None:
    """What the robot's turning says of a stream's clock, before it was shifted by that; None where it says nothing."""
    if measured is None:
        return None
    return {
        "against": measured.against,
        "ahead_s": _rounded(measured.offset.lag_s),
        "within_s": _rounded(measured.offset.sd_s),
        "correlation": _rounded(measured.offset.correlation),
    }


def _step(jump: Jump, time: StreamTime, header_ns: Int64[Array, " n"], start_ns: int) -> dict[str, float]:
    at = np.flatnonzero(time.order == jump.position)
    moment = int(time.stamps_ns[at[0]]) if at.size else int(header_ns[jump.position])
    return {"at_s": _rounded((moment - start_ns) * 1e-9), "by_s": _rounded(jump.by_ns * 1e-9)}


def _notes(name: str, time: StreamTime, clocks: Clocks) -> list[Note]:
    jumps, (header_ns, record_ns) = clocks.jumps[name], clocks.as_recorded(name)
    notes = [*time.notes, *clocks.notes(name)]
    if jumps:
        largest = max(jumps, key=lambda jump: abs(jump.by_ns)).by_ns * 1e-9
        times = "once" if len(jumps) == 1 else f"{len(jumps)} times"
        what = f"the header clock stepped {times}, by up to {largest:+.3f} s; taken out by the pace of record"
        notes.append(Note("clock.stepped", what))
    stamped = header_ns > 0
    if stamped.any():
        delay = (record_ns[stamped] - header_ns[stamped]) * 1e-9
        late = delay - np.median(delay) > LATE_S
        if late.any():
            what = f"{int(late.sum())} messages were recorded more than {LATE_S:g} s late; their stamps count"
            notes.append(Note("clock.late", what))
    return notes


def _rounded(value: float | np.floating) -> float:
    return round(float(value), 6)
