"""An episode's files before they are part of the data set."""

import shutil
from dataclasses import dataclass
from pathlib import Path

from navtool.datasets.store.stats import Stats


@dataclass(frozen=True, slots=True)
class Numbering:
    """An episode's number in the data set."""

    episode_index: int
    index_from: int
    """Number of rows before it."""


@dataclass(frozen=True, slots=True)
class EpisodeFolder:
    """The staged files of one episode, laid out as they will be in the data set."""

    root: Path
    numbering: Numbering
    rows: int
    stats: dict[str, Stats]

    @property
    def data(self) -> Path:
        """The staged data file."""
        return self.root / "data.parquet"

    def video(self, key: str) -> Path:
        """The staged video of a camera, by its column."""
        return self.root / f"{key}.mp4"

    @property
    def beside(self) -> Path:
        """The staged folder of what LeRobot does not hold."""
        return self.root / "episode"


def streams_folder(staged: Path) -> Path:
    """Where, in an episode's staged folder, the small streams lie at their own rates."""
    return staged / "episode" / "streams"


def discard(folder: Path) -> None:
    """Take a staged episode away."""
    shutil.rmtree(folder, ignore_errors=True)
