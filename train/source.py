"""What training needs of its data: `navtool.datasets.store.reader.NavDataset` offers it, as may any other store."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from navtool.pipeline.geometry.camera import CameraModel


class EpisodeView(Protocol):
    """Rows that were recorded together: ``start`` to ``stop - 1`` of the data set."""

    @property
    def index(self) -> int:
        """Number of the episode, counted from 0 without gaps."""

    @property
    def start(self) -> int:
        """First row."""

    @property
    def stop(self) -> int:
        """Row after the last one."""

    @property
    def place(self) -> str:
        """Where it was recorded; empty where nobody said."""

    @property
    def source(self) -> str:
        """Name of the recording it comes from."""


class CalibrationView(Protocol):
    """The camera of an episode, scaled to the stored images."""

    @property
    def camera(self) -> CameraModel | None:
        """None where the recording has no usable calibration."""

    @property
    def base_camera(self) -> NDArray[np.float64] | None:
        """Pose of the camera's optical frame in base; None where it is unknown."""

    @property
    def base_height_m(self) -> float:
        """Height of the base frame above the ground."""

    @property
    def robot_width_m(self) -> float:
        """Width of the swath that the robot drives over."""


class Source(Protocol):
    """Data of any kind, in rows that belong to episodes: what a run must know to split them and to say what it saw."""

    @property
    def root(self) -> Path | None:
        """The folder; None where the data were never in one."""

    @property
    def episodes(self) -> Sequence[EpisodeView]:
        """All episodes in the order of their rows."""

    def lineage(self) -> dict[str, object]:
        """What the data were made from; plain values."""


class NavSource(Source, Protocol):
    """Rows of a data set in random access."""

    @property
    def fps(self) -> int:
        """Rows a second."""

    @property
    def features(self) -> Mapping[str, object]:
        """The columns by name; a data set without cameras or clouds lacks theirs."""

    def __len__(self) -> int:
        """Number of rows."""

    def column(self, name: str) -> NDArray[np.generic]:
        """All rows of a small column, such as ``observation.state``."""

    def points(self, index: int) -> NDArray[np.float32]:
        """The cloud of a row, (10000, 3), padding behind its count."""

    def image(self, index: int) -> NDArray[np.uint8]:
        """The camera image of a row, (240, 320, 3) RGB."""

    def calibration(self, episode: int) -> CalibrationView:
        """The camera of an episode."""


def column_or(source: NavSource, name: str, default: float) -> NDArray[np.generic]:
    """A column of one value a row, (rows,); the default in each row where the data set lacks it."""
    if name not in source.features:
        return np.full(len(source), default)
    return source.column(name).reshape(len(source))
