"""Samples of success along a trajectory: sensors, velocity history, the trajectory drawn, and what came of it."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import torch
from torch import Tensor

from navtool.datasets.store.schema import CLOUD_SIZE
from navtool.train.config import TrainConfig
from navtool.train.samples import Samples
from navtool.train.source import NavSource, column_or
from navtool.train.success.painter import painter_of
from navtool.train.success.row_cache import SampleCaches, fill_caches
from navtool.train.success.windows import DataConfig, WindowReport, Windows, plan_windows

_MOVING = 0.1
"""A robot with a speed (m/s) or turn (rad/s) above this moves."""


class Sample(NamedTuple):
    """One row, or a batch of them with a leading axis B. The first six are the network's inputs in their order."""

    image: Tensor
    """RGB uint8 [3, h, w]; zeros where the row has no camera frame."""
    points: Tensor
    """LiDAR points in metres in base axes, float32 [P, 3]; repetitions behind ``point_count``."""
    point_count: Tensor
    """Number of points, int64 []."""
    velocity: Tensor
    """[v_mps, omega_radps] of the history, oldest first, float32 [H, 2]."""
    trajectory: Tensor
    """Swath of the row's velocity: uint8 [1, h, w], 255 on it."""
    reliability: Tensor
    """[r_img, r_point] in [0, 1], float32 [2]; 0 for a missing modality."""
    target: Tensor
    """E_t, float32 [T], 0 where not known."""
    known: Tensor
    """bool [T]."""
    row: Tensor
    """Row t of the data set, int64 []."""

    def inputs(self) -> tuple[Tensor, Tensor, Tensor, Tensor, Tensor, Tensor]:
        """What the network's forward takes."""
        return self.image, self.points, self.point_count, self.velocity, self.trajectory, self.reliability


class SampleDataset(Samples[Sample]):
    """The samples of planned windows. Reading one touches one camera frame and one cloud.

    A sample depends on the data set and the configuration alone, not on the cache or on what was read before.
    """

    report: WindowReport

    def __init__(
        self, source: NavSource, windows: Windows, config: DataConfig, caches: SampleCaches | None = None
    ) -> None:
        self.windows = windows
        self.row, self.episode, self.report = windows.row, windows.episode, windows.report
        self.source = source
        self._caches = caches
        self._history_steps = config.history_steps
        self._state = source.column("observation.state").astype(np.float32)
        self._image_valid, self._cloud_valid, self._r_img, self._r_point, self._count = (
            column_or(source, name, 0.0)
            for name in (
                "valid.camera",
                "valid.lidar",
                "reliability.camera",
                "reliability.cloud",
                "lidar.count",
            )
        )
        self._painters = {index: painter_of(source, index, config) for index in np.unique(windows.episode).tolist()}

    def __getitem__(self, index: int) -> Sample:
        """Sample ``index`` of the windows."""
        row = int(self.windows.row[index])
        painter = self._painters[int(self.windows.episode[index])]
        seen, scanned = bool(self._image_valid[row]), bool(self._cloud_valid[row])
        blank = torch.zeros((3, painter.camera.height, painter.camera.width), dtype=torch.uint8)
        return Sample(
            image=self._image(row) if seen else blank,
            points=self._points(row) if scanned else torch.zeros((CLOUD_SIZE, 3)),
            point_count=torch.tensor(int(self._count[row]) if scanned else 0),
            velocity=torch.from_numpy(self._state[self.windows.history(index, self._history_steps)]),
            trajectory=torch.from_numpy(painter.draw(self._state[row]))[None],
            reliability=torch.tensor([float(self._r_img[row]) * seen, float(self._r_point[row]) * scanned]),
            target=torch.from_numpy(self.windows.target[index]),
            known=torch.from_numpy(self.windows.known[index]),
            row=torch.tensor(row),
        )

    def unseen_share(self, most: int = 200) -> float:
        """Share of the samples of a moving robot whose trajectory lies outside the picture, 0-1; 0 where none moves.

        The network knows candidate trajectories by these images alone: where they are empty it cannot.

        Args:
            most: How many samples are looked at, evenly chosen.
        """
        moving = np.flatnonzero(np.abs(self._state[self.windows.row]).max(axis=1) > _MOVING)
        chosen = moving[np.unique(np.linspace(0, moving.size - 1, min(most, moving.size)).astype(np.int64))]
        rows, episodes = self.windows.row[chosen].tolist(), self.windows.episode[chosen].tolist()
        unseen = [not self._painters[e].draw(self._state[r]).any() for r, e in zip(rows, episodes, strict=True)]
        return float(np.mean(unseen)) if unseen else 0.0

    def share(self, caches: SampleCaches) -> None:
        """Take frames and clouds from memory from now on, as far as they are there."""
        self._caches = caches

    def _image(self, row: int) -> Tensor:
        held = self._caches.images.get(row) if self._caches is not None else None
        return (torch.from_numpy(self.source.image(row)) if held is None else held).permute(2, 0, 1)

    def _points(self, row: int) -> Tensor:
        held = self._caches.clouds.get(row) if self._caches is not None else None
        return torch.from_numpy(np.array(self.source.points(row))) if held is None else held


def success_samples(source: NavSource, episodes: Sequence[int], config: TrainConfig) -> SampleDataset:
    """The samples of the given episodes.

    Raises:
        TrainError: The data set labels fewer steps than the horizon has.
    """
    return SampleDataset(source, plan_windows(source, episodes, config.data), config.data)


def hold_rows(parts: Sequence[SampleDataset], config: TrainConfig) -> None:
    """Read the frames and clouds of these samples into memory that they share, as many as ``data.cache_mib`` holds."""
    rows = [row for part in parts for row in part.row.tolist()]
    caches = fill_caches(parts[0].source, rows, config.data.cache_mib)
    for part in parts:
        part.share(caches)
