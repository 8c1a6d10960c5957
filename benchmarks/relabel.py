"""Relabelling a data set of 37,000 rows: time and memory, against writing its files anew with pyarrow."""

import json
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
from _bags import write_bag
from _report import Row, write_report

from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.ingest.ingest import ingest
from navtool.datasets.robot.config import RobotConfig
from navtool.datasets.store.data_file import write_data
from navtool.datasets.store.reader import NavDataset
from navtool.datasets.store.replace import entry_stats
from navtool.datasets.store.schema import IMAGE_KEY
from navtool.datasets.store.staged_episode import EpisodeFolder
from navtool.datasets.store.writer import open_store

NAVTOOL = str(Path(sys.executable).with_name("navtool"))
ROWS = 37_000
BAR_S, BAR_MIB = 60.0, 1024.0


def main() -> None:
    folder = Path(tempfile.mkdtemp(prefix="navtool-bench-"))
    try:
        ingest([write_bag(folder, "ros1", 0.4e9)], folder / "one", RobotConfig(), IngestConfig())
        rows, size = multiply(folder / "one", folder / "many")
        started = time.perf_counter()
        command = [NAVTOOL, "label", str(folder / "many"), "--json"]
        done = subprocess.run(command, capture_output=True, text=True, check=True)  # noqa: S603
        seconds = time.perf_counter() - started
        peak = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024
        rewritten = len(json.loads(done.stdout)["rewritten"])
        peer = rewrite_all(folder / "many", folder / "copy.parquet")
        what = f"relabel {rows} rows, {size / 1e6:.0f} MB, {rewritten} files, against pyarrow writing them anew"
        write_report(
            "relabel",
            [
                Row(
                    what=what,
                    ours=seconds,
                    peer=peer,
                    ratio=peer / seconds,
                    unit="s",
                    bar=BAR_S,
                    holds=seconds <= BAR_S,
                ),
                Row(what="peak memory of it", ours=peak, unit="MiB", bar=BAR_MIB, holds=peak < BAR_MIB),
            ],
        )
    finally:
        shutil.rmtree(folder)


def multiply(source: Path, out: Path) -> tuple[int, int]:
    """A data set of many episodes alike out of one of a single episode: its rows and the bytes of its data files."""
    one = NavDataset(source)
    columns = {key: one.column(key).copy() for key in one.features if key != IMAGE_KEY}
    stats = entry_stats(one.layout.episode_meta(0))
    with open_store(out) as store:
        while store.rows < ROWS:
            folder = EpisodeFolder(store.layout.staging, store.numbering(None), len(one), stats)
            columns["index"] = np.arange(len(one), dtype=np.int64) + folder.numbering.index_from
            columns["episode_index"] = np.full(len(one), folder.numbering.episode_index, np.int64)
            write_data(folder.data, one.features, columns)
            shutil.copy(one.layout.video(0), folder.video(IMAGE_KEY))
            shutil.copytree(one.layout.episode(0), folder.beside, ignore=shutil.ignore_patterns("clouds", "points"))
            name = f"{store.episodes:064x}"
            store.commit(folder, one.description, one.provenance()[0] | {"sha256": name, "source": name})
        files = [store.layout.data(number) for number in range(store.episodes)]
        return store.rows, sum(file.stat().st_size for file in files)


def rewrite_all(root: Path, target: Path) -> float:
    """Seconds to read and write every data file as pyarrow does by itself."""
    dataset = NavDataset(root)
    started = time.perf_counter()
    for episode in dataset.episodes:
        table = pq.read_table(dataset.layout.data(episode.index))
        pq.write_table(table, target, compression="zstd", compression_level=1)
    return time.perf_counter() - started


if __name__ == "__main__":
    main()
