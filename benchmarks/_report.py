"""What every benchmark shares: fair timing against a peer, the printed table, and the JSON report."""

import json
import os
import platform
import statistics
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

OUT = Path(__file__).parent / "out"


@dataclass(frozen=True, kw_only=True)
class Row:
    """One measured figure; the bar, where there is one, is for the ratio or, without a peer, for our own figure."""

    what: str
    ours: float
    peer: float | None = None
    ratio: float | None = None
    unit: str
    bar: float | None = None
    holds: bool = True


def median_seconds(*functions: Callable[[], object], rounds: int, calls: int = 3) -> list[float]:
    """Return the median time of one call of each function.

    The functions take turns of `calls` calls, so that a busy machine slows all of them alike; each turn begins with
    one call that is not timed, which finds the caches and the allocator as the other function left them.
    """
    times: list[list[float]] = [[] for _ in functions]
    for _ in range(rounds):
        for function, taken in zip(functions, times, strict=True):
            function()
            for _ in range(calls):
                start = time.perf_counter()
                function()
                taken.append(time.perf_counter() - start)
    return [statistics.median(taken) for taken in times]


def write_report(name: str, rows: Sequence[Row]) -> Path:
    """Print the rows as a table and write them to benchmarks/out/<name>.json."""
    width = max(len(row.what) for row in rows)
    print(f"{name}\n{'':{width}}  {'ours':>10} {'peer':>10} {'ratio':>8} {'bar':>8}  unit")
    for row in rows:
        figures = [f"{'-' if value is None else format(value, '.4g'):>{size}}" for value, size in _cells(row)]
        verdict = "" if row.bar is None else ("  holds" if row.holds else "  MISSED")
        print(f"{row.what:{width}}  {' '.join(figures)}  {row.unit}{verdict}")
    OUT.mkdir(exist_ok=True)
    path = OUT / f"{name}.json"
    report = {"name": name, "machine": machine(), "rows": [asdict(row) for row in rows]}
    path.write_text(json.dumps(report, indent=2) + "\n", encoding="utf-8")
    print(f"-> {path}")
    return path


def machine() -> dict[str, str | int]:
    """Return what the figures depend on: processor, usable cores, Python."""
    cpuinfo = Path("/proc/cpuinfo")
    lines = cpuinfo.read_text(encoding="utf-8").splitlines() if cpuinfo.is_file() else []
    models = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return {
        "processor": models[0] if models else platform.processor(),
        "cores": len(os.sched_getaffinity(0)),
        "system": f"{platform.system()} {platform.machine()}",
        "python": platform.python_version(),
    }


def _cells(row: Row) -> list[tuple[float | None, int]]:
    return [(row.ours, 10), (row.peer, 10), (row.ratio, 8), (row.bar, 8)]
