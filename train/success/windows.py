"""Which rows of a data set can be samples, with their targets and masks, and why the others cannot."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from navtool.base.setting_checks import outside
from navtool.base.setting_error import refuse
from navtool.train.errors import TrainError
from navtool.train.samples import SampleReport
from navtool.train.source import NavSource, column_or


class MissingModality(StrEnum):
    """What becomes of a row whose camera frame or cloud is missing."""

    exclude = "exclude"
    """It is no sample; the report counts it."""
    blank = "blank"
    """It is a sample with a black image or an empty cloud, of reliability 0."""


@dataclass(kw_only=True, slots=True)
class DataConfig:
    """What a sample is made of, and how samples are held in memory."""

    history_steps: int = 50
    """Rows of velocity history H up to and including the row itself, >= 1; the paper has 50."""

    horizon_steps: int = 10
    """Steps T of the success vector, 1 to 10, all that the data set knows; the paper has 10."""

    missing_modality: MissingModality = MissingModality.exclude
    """What becomes of rows without camera frame or cloud."""

    robot_width_m: float | None = None
    """Width of the drawn trajectory in metres, above 0; None takes each recording's own from its calibration."""

    cache_mib: int = 1024
    """Memory for clouds and decoded images, in MiB, >= 0. 1024 hold 3,060 rows; the others are read anew each epoch."""

    def __post_init__(self) -> None:
        refuse(
            outside(self, 1, math.inf, "history_steps", cure="the paper uses 50"),
            outside(self, 1, math.inf, "horizon_steps", cure="the paper uses 10"),
            outside(self, 0, math.inf, "robot_width_m", unit="m", above=True, cure="null takes the recording's"),
            outside(self, 0, math.inf, "cache_mib", unit="MiB", cure="0 caches nothing"),
        )


@dataclass(frozen=True, slots=True)
class WindowReport(SampleReport):
    """How many rows became samples, and why the others did not.

    A row is excluded by the first reason that holds of: no_state (no velocity at the row), history_gap (none at a row
    of the history), no_image, no_cloud, no_calibration (the trajectory cannot be drawn), no_known_step.
    """

    masked_steps: dict[str, int]
    """Steps of the samples that carry no label, by reason: episode_end, state_gap, unknown (docs/papers.md, E_t)."""
    positives: int
    """Samples whose known steps are all 1."""
    negatives: int
    """Samples with a known step of 0."""

    def cure(self) -> str:
        """What gives more samples."""
        if self.excluded["no_image"] or self.excluded["no_cloud"]:
            return "data.missing_modality=blank trains on rows without camera or cloud"
        return "run `navtool label` on the data set" if self.excluded["no_known_step"] else "record more"


@dataclass(frozen=True, slots=True)
class Windows:
    """Samples of some episodes, in the order of their rows."""

    row: NDArray[np.int64]
    """Row t of each sample, (n,)."""
    episode: NDArray[np.int64]
    """Its episode, (n,)."""
    first_row: NDArray[np.int64]
    """First row of its episode, (n,)."""
    target: NDArray[np.float32]
    """E_t, the outcome at t..t+T-1, (n, T); 0 where it is not known."""
    known: NDArray[np.bool_]
    """False where a step has no label, (n, T)."""
    report: WindowReport
    """What was left out."""

    def __len__(self) -> int:
        """Number of samples."""
        return len(self.row)

    def history(self, sample: int, steps: int) -> NDArray[np.int64]:
        """Rows t-H+1..t; the episode's first row stands in before it, as with LeRobot's ``delta_timestamps``."""
        rows = int(self.row[sample]) + np.arange(1 - steps, 1, dtype=np.int64)
        return np.maximum(rows, int(self.first_row[sample]))


def plan_windows(source: NavSource, episodes: Sequence[int], config: DataConfig) -> Windows:
    """The samples of the given episodes.

    A row is a sample if its velocity and those of its history are valid, camera and cloud are there (or blanks are
    allowed), the camera is calibrated, and at least one step of its horizon has a known outcome. Small columns are read
    once; no image or cloud is touched.

    Raises:
        TrainError: The data set labels fewer steps than the horizon has.
    """
    _check(source, config)
    rows = _rows(source, episodes)
    state = _flags(source, "valid.state")
    ahead = rows.row[:, None] + np.arange(config.horizon_steps)
    inside = ahead < rows.stop[:, None]
    ahead = np.minimum(ahead, rows.stop[:, None] - 1)
    labelled = source.column("label.known")[rows.row, : config.horizon_steps].astype(np.bool_)
    known = labelled & inside & state[ahead]

    reasons = _reasons(source, rows, state, config) | {"no_known_step": ~known.any(axis=1)}
    usable = ~np.any(list(reasons.values()), axis=0)
    outcome = source.column("label.outcome").reshape(len(source))[ahead]
    target = np.where(known, outcome, 0).astype(np.float32)[usable]
    negative = np.any(known[usable] & (target == 0.0), axis=1)
    masked = {"episode_end": ~inside, "state_gap": inside & ~state[ahead], "unknown": inside & state[ahead] & ~labelled}
    report = WindowReport(
        rows=len(rows.row),
        samples=int(usable.sum()),
        excluded=_first_reason(reasons),
        masked_steps={name: int(steps[usable].sum()) for name, steps in masked.items()},
        positives=int((~negative).sum()),
        negatives=int(negative.sum()),
    )
    return Windows(rows.row[usable], rows.episode[usable], rows.start[usable], target, known[usable], report)


class _Rows(NamedTuple):
    """Each row with its episode's number, first row and row after the last, all (n,)."""

    row: NDArray[np.int64]
    episode: NDArray[np.int64]
    start: NDArray[np.int64]
    stop: NDArray[np.int64]


def _rows(source: NavSource, episodes: Sequence[int]) -> _Rows:
    spans = [source.episodes[index] for index in episodes]
    row = np.concatenate([np.arange(0), *(np.arange(span.start, span.stop) for span in spans)])
    table = np.array([[span.index, span.start, span.stop] for span in spans], dtype=np.int64).reshape(-1, 3)
    episode, start, stop = np.repeat(table, table[:, 2] - table[:, 1], axis=0).T
    return _Rows(row, episode, start, stop)


def _reasons(
    source: NavSource, rows: _Rows, state: NDArray[np.bool_], config: DataConfig
) -> dict[str, NDArray[np.bool_]]:
    """For each reason that lies in the inputs, the rows that it excludes."""
    gaps = np.concatenate([[0], np.cumsum(~state)])
    oldest = np.maximum(rows.row + 1 - config.history_steps, rows.start)
    drawable = {index: _drawable(source, index) for index in np.unique(rows.episode).tolist()}
    strict = config.missing_modality is MissingModality.exclude
    return {
        "no_state": ~state[rows.row],
        "history_gap": gaps[rows.row + 1] > gaps[oldest],
        "no_image": ~_flags(source, "valid.camera")[rows.row] & strict,
        "no_cloud": ~_flags(source, "valid.lidar")[rows.row] & strict,
        "no_calibration": ~np.array([drawable[index] for index in rows.episode.tolist()], dtype=np.bool_),
    }


def _first_reason(reasons: dict[str, NDArray[np.bool_]]) -> dict[str, int]:
    counts: dict[str, int] = {}
    taken = np.zeros_like(next(iter(reasons.values())))
    for name, excluded in reasons.items():
        counts[name] = int((excluded & ~taken).sum())
        taken = taken | excluded
    return counts


def _drawable(source: NavSource, episode: int) -> bool:
    calibration = source.calibration(episode)
    return calibration.camera is not None and calibration.base_camera is not None


def _flags(source: NavSource, name: str) -> NDArray[np.bool_]:
    return column_or(source, name, default=False).astype(np.bool_)


def _check(source: NavSource, config: DataConfig) -> None:
    width = source.column("label.known").shape[1]
    if config.horizon_steps > width:
        raise TrainError(
            f"data.horizon_steps = {config.horizon_steps}, but the data set labels {width} steps ahead",
            where="data.horizon_steps",
            cure=f"set data.horizon_steps={width} or less",
        )
