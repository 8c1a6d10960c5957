"""What ingest costs: seconds a gigabyte, rows a second against LeRobot's own writer, workers, memory."""

import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from _bags import CONTAINERS, sights, write_bag
from _report import Row, write_report
from numpy.typing import NDArray

from navtool.datasets.recording.identity import size_of
from navtool.datasets.store.reader import NavDataset

NAVTOOL = str(Path(sys.executable).with_name("navtool"))
GB = 1e9
SMALL, LARGE = 0.4 * GB, 4 * GB
ROWS = 200
BAR_S_PER_GB, BAR_ROWS, BAR_WORKERS, BAR_MIB = 10.0, 1.5, 1.7, 1024.0


def main() -> None:
    folder = Path(tempfile.mkdtemp(prefix="navtool-bench-"))
    try:
        rows = speed_rows(folder)
        rows.append(worker_row(folder))
        rows += memory_rows(folder)
        rows.append(lerobot_row(folder, rows_per_s=float(rows[0].peer or 0)))
        write_report("ingest", [Row(**{**row.__dict__, "peer": None}) if row.unit == "s/GB" else row for row in rows])
    finally:
        shutil.rmtree(folder)


def ingest(bags: list[Path], out: Path, workers: int = 1) -> tuple[float, dict[str, Any]]:
    """Seconds of the whole process, and its report; the data set is made anew."""
    shutil.rmtree(out, ignore_errors=True)
    command = [NAVTOOL, "ingest", *map(str, bags), "--out", str(out), "--workers", str(workers), "--json"]
    started = time.perf_counter()
    done = subprocess.run(command, capture_output=True, text=True, check=True, env=environment(out.parent))  # noqa: S603
    report: dict[str, Any] = json.loads(done.stdout)
    return time.perf_counter() - started, report


def environment(folder: Path) -> dict[str, str]:
    """Where byte code is kept, as it is once navtool is installed; some shells forbid it, to keep checkouts clean."""
    kept = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    return kept | {"PYTHONPYCACHEPREFIX": str(folder / "bytecode")}


def speed_rows(folder: Path) -> list[Row]:
    """A gigabyte in each container, one worker."""
    rows = []
    first = write_bag(folder, "ros1", 0.01 * GB, name="first")
    ingest([first], folder / "out")  # compiles what the others only load
    _remove(first)
    for container in CONTAINERS:
        bag = write_bag(folder, container, GB, name=f"one-{container}")
        seconds, report = ingest([bag], folder / "out")
        cost = seconds / (size_of(bag) / GB)
        shown = {"ros1": "ROS 1", "mcap": "MCAP, zstd", "db3": "db3"}[container]
        what = f"{shown}, {size_of(bag) / GB:.2f} GB, {report['rows']} rows, one worker"
        holds = cost <= BAR_S_PER_GB
        rows.append(
            Row(what=what, ours=cost, peer=report["rows"] / seconds, unit="s/GB", bar=BAR_S_PER_GB, holds=holds)
        )
        _remove(bag)
    return rows


def worker_row(folder: Path) -> Row:
    """Two recordings by one worker and by two."""
    bags = [write_bag(folder, "ros1", GB, seed=n, name=f"pair-{n}") for n in range(2)]
    one, _ = ingest(bags, folder / "out")
    two, _ = ingest(bags, folder / "out", workers=2)
    for bag in bags:
        _remove(bag)
    ratio = one / two
    return Row(
        what="two recordings, two workers against one",
        ours=two,
        peer=one,
        ratio=ratio,
        unit="s",
        bar=BAR_WORKERS,
        holds=ratio >= BAR_WORKERS,
    )


def memory_rows(folder: Path) -> list[Row]:
    """Peak memory of short and long recordings."""
    rows = []
    for size in (SMALL, LARGE):
        bag = write_bag(folder, "ros1", size, name="long")
        _, report = ingest([bag], folder / "out")
        peak = float(report["peak_rss_mib"])
        what = f"peak memory, {size / GB:.1f} GB"
        rows.append(Row(what=what, ours=peak, unit="MiB", bar=BAR_MIB, holds=peak < BAR_MIB))
        _remove(bag)
    return rows


def lerobot_row(folder: Path, rows_per_s: float) -> Row:
    """Rows a second of the whole ingest against LeRobot's writer, which is given decoded frames and finished clouds."""
    os.environ["HF_HOME"] = str(folder / "hf")
    from lerobot.datasets.lerobot_dataset import LeRobotDataset  # noqa: PLC0415 - reads HF_HOME when it is imported

    bag = write_bag(folder, "ros1", 0.05 * GB, name="few")
    ingest([bag], folder / "out")
    dataset = NavDataset(folder / "out")
    clouds = [dataset.points(row) for row in range(min(len(dataset), 40))]
    frames = [frame[::2, ::2] for frame in sights()[0]]
    features = {
        "observation.images.front": {
            "dtype": "video",
            "shape": (240, 320, 3),
            "names": ["height", "width", "channels"],
        },
        "observation.state": {"dtype": "float32", "shape": (2,), "names": ["v", "w"]},
        "action": {"dtype": "float32", "shape": (2,), "names": ["v", "w"]},
        "observation.lidar.points": {"dtype": "float32", "shape": (10000, 3), "names": ["point", "xyz"]},
    }
    peer = LeRobotDataset.create("local/peer", 10, features, root=folder / "peer", use_videos=True)
    zero: NDArray[np.float32] = np.zeros(2, np.float32)
    started = time.perf_counter()
    for row in range(ROWS):
        image, cloud = np.ascontiguousarray(frames[row % len(frames)]), clouds[row % len(clouds)]
        peer.add_frame(
            {
                "observation.images.front": image,
                "observation.state": zero,
                "action": zero,
                "observation.lidar.points": cloud,
                "task": "drive",
            }
        )
    peer.save_episode()
    peer.finalize()
    other = ROWS / (time.perf_counter() - started)
    ratio = rows_per_s / other
    return Row(
        what="rows a second from a ROS 1 bag, against LeRobot's writer given decoded frames and clouds",
        ours=rows_per_s,
        peer=other,
        ratio=ratio,
        unit="rows/s",
        bar=BAR_ROWS,
        holds=ratio >= BAR_ROWS,
    )


def _remove(bag: Path) -> None:
    if bag.is_dir():
        shutil.rmtree(bag)
    else:
        bag.unlink()


if __name__ == "__main__":
    main()
