"""Random reads of whole samples, cloud and frame included, against LeRobot's reader with the same clouds."""

import os
import shutil
import tempfile
from itertools import cycle
from pathlib import Path

import numpy as np
from _bags import write_bag
from _report import Row, median_seconds, write_report

from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.ingest.ingest import ingest
from navtool.datasets.robot.config import RobotConfig
from navtool.datasets.store.reader import NavDataset
from navtool.datasets.store.schema import IMAGE_KEY

BAR = 5.0


def main() -> None:
    folder = Path(tempfile.mkdtemp(prefix="navtool-bench-"))
    os.environ["HF_HOME"] = str(folder / "hf")
    from navtool.train.lerobot_dataset import NavLeRobotDataset  # noqa: PLC0415 - LeRobot reads HF_HOME when imported

    try:
        ingest([write_bag(folder, "ros1", 0.4e9)], folder / "out", RobotConfig(), IngestConfig())
        ours = NavDataset(folder / "out")
        theirs = NavLeRobotDataset(folder / "out", video_backend="pyav")
        rows = cycle(np.random.default_rng(0).permutation(len(ours)).tolist())
        small = [key for key in ours.features if key != IMAGE_KEY]

        def read() -> object:
            row = next(rows)
            return ours.points(row), ours.image(row), [ours.column(key)[row] for key in small]

        mine, peer = median_seconds(read, lambda: theirs[next(rows)], rounds=30)
        what = f"a random sample of {len(ours)}, cloud, frame and all columns"
        row = Row(
            what=what,
            ours=1000 * mine,
            peer=1000 * peer,
            ratio=peer / mine,
            unit="ms",
            bar=BAR,
            holds=peer / mine >= BAR,
        )
        write_report("reads", [row])
    finally:
        shutil.rmtree(folder)


if __name__ == "__main__":
    main()
