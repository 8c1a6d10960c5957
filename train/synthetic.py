"""A data set made of numbers: small, learnable and without files, for benchmarks and checks."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from navtool.datasets.robot.calibration import Calibration
from navtool.datasets.robot.recorded_geometry import RecordedGeometry
from navtool.datasets.store.reader import Episode
from navtool.datasets.store.schema import CLOUD_SIZE, HORIZON_STEPS, IMAGE_HEIGHT_PX, IMAGE_WIDTH_PX
from navtool.pipeline.geometry.camera import CameraModel

_TILT = (np.cos(0.5), np.sin(0.5))
_OPTICAL_IN_BASE = np.array(
    [[0.0, -_TILT[1], _TILT[0], 0.2], [-1.0, 0.0, 0.0, 0.0], [0.0, -_TILT[0], -_TILT[1], 0.5], [0.0, 0.0, 0.0, 1.0]]
)
_FAILURE_PERIOD, _FAILURE_LENGTH = 40, 8


@dataclass(kw_only=True, slots=True)
class SyntheticConfig:
    """Sizes of a synthetic data set."""

    places: list[str] = field(default_factory=lambda: ["field", "park", "wood"])
    """Place of each episode."""

    rows: int = 60
    """Rows an episode, >= 1."""

    image_height: int = IMAGE_HEIGHT_PX
    """Image height in pixels."""

    image_width: int = IMAGE_WIDTH_PX
    """Image width in pixels."""

    points: int = 400
    """Points a cloud that are not padding, at most 10,000."""

    fps: int = 10
    """Rows a second."""

    seed: int = 0
    """Everything in the data set is a function of this configuration."""


class SyntheticSource:
    """A robot that fails now and then, and whose sensors show it coming.

    Every 40 rows a wall stands in the way for 8 rows: the image darkens and the cloud comes near as it approaches, and
    the outcome is 0 while it is there. It offers what `navtool.train.source.NavSource` asks for. Columns may be
    replaced to build other cases.
    """

    def __init__(self, config: SyntheticConfig) -> None:
        self._config = config
        self.fps = config.fps
        self.root: Path | None = None
        self.episodes = tuple(
            Episode(index, index * config.rows, (index + 1) * config.rows, f"{place}_{index}.bag", place)
            for index, place in enumerate(config.places)
        )
        self.columns: dict[str, NDArray[np.generic]] = self._columns()

    def _columns(self) -> dict[str, NDArray[np.generic]]:
        rng = np.random.default_rng(self._config.seed)
        rows, per_episode = len(self), self._config.rows
        within = np.arange(rows) % per_episode
        phase = (within + rng.integers(0, _FAILURE_PERIOD, len(self.episodes)).repeat(per_episode)) % _FAILURE_PERIOD
        self._distance = np.where(phase < _FAILURE_LENGTH, 0.0, 1.0 - (phase - _FAILURE_LENGTH) / _FAILURE_PERIOD)
        state = np.column_stack([rng.uniform(0.3, 1.2, rows), rng.uniform(-0.5, 0.5, rows)])
        ahead = np.minimum(within[:, None] + np.arange(HORIZON_STEPS), per_episode)
        return {
            "observation.state": state.astype(np.float32),
            "lidar.count": np.full(rows, self._config.points, dtype=np.int64),
            "reliability.camera": rng.uniform(0.4, 0.9, rows).astype(np.float32),
            "reliability.cloud": rng.uniform(0.2, 0.5, rows).astype(np.float32),
            "valid.camera": np.ones(rows, dtype=np.bool_),
            "valid.lidar": np.ones(rows, dtype=np.bool_),
            "valid.state": np.ones(rows, dtype=np.bool_),
            "label.outcome": (phase >= _FAILURE_LENGTH).astype(np.int64),
            "label.known": ahead < per_episode,
        }

    @property
    def features(self) -> Mapping[str, object]:
        """The columns by name."""
        return self.columns

    def __len__(self) -> int:
        """Number of rows."""
        return self._config.rows * len(self._config.places)

    def column(self, name: str) -> NDArray[np.generic]:
        """All rows of a column."""
        return self.columns[name]

    def points(self, row: int) -> NDArray[np.float32]:
        """A wall at the obstacle's distance, noisy."""
        rng = np.random.default_rng([self._config.seed, row, 0])
        cloud = np.zeros((CLOUD_SIZE, 3), dtype=np.float32)
        size = (self._config.points, 3)
        cloud[: self._config.points] = rng.normal((1.0 + 9.0 * self._distance[row], 0.0, 0.5), (0.05, 2.0, 0.3), size)
        return cloud

    def image(self, row: int) -> NDArray[np.uint8]:
        """Grey noise, the darker the nearer the obstacle."""
        rng = np.random.default_rng([self._config.seed, row, 1])
        shape = (self._config.image_height, self._config.image_width, 3)
        grey = 30 + int(190 * self._distance[row]) + rng.integers(-20, 21, shape)
        return grey.astype(np.uint8)  # 10 to 240

    def calibration(self, episode: int) -> Calibration:
        """A camera half a metre above the ground, tilted down by half a radian; the same in each episode."""
        del episode
        width, height = self._config.image_width, self._config.image_height
        camera = CameraModel(width, height, 0.6 * width, 0.6 * width, (width - 1) / 2, (height - 1) / 2)
        return Calibration(
            camera=camera,
            base_camera=_OPTICAL_IN_BASE.copy(),
            base_lidar=None,
            base_imu=None,
            base_odometry=None,
            base_height_m=0.0,
            robot_width_m=0.5,
            sources={"camera": "synthetic"},
            recorded=RecordedGeometry(),
        )

    def lineage(self) -> dict[str, object]:
        """The configuration; there are no recordings."""
        return {"synthetic": {"seed": self._config.seed, "rows": len(self)}, "recordings": []}
