"""Walks along one recording or data set, as the commands do."""

from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path

from navtool.base.progress import Progress, Silent
from navtool.methods.along.method import Method
from navtool.methods.along.report import Report
from navtool.methods.along.run import run_along
from navtool.methods.along.source import Input
from navtool.methods.intensity_map.config import MapRunConfig
from navtool.methods.intensity_map.fit_report import FitReport
from navtool.methods.intensity_map.maps import IntensityMaps
from navtool.methods.intensity_map.report import MapReport
from navtool.methods.intensity_map.threshold import IntensityThreshold, ThresholdRunConfig


def walked[T, R, P: Report](
    inputs: Sequence[Input],
    method: Method[T, R, P],
    out: Path,
    truth: Path | None = None,
    progress: Progress | None = None,
) -> P:
    """What a method reports of inputs, which are opened for it."""
    with ExitStack() as opened:
        sources = [opened.enter_context(one.open()) for one in inputs]
        return run_along(sources, method, out, progress or Silent(), truth)


def intensity_maps(
    named: Input, out: Path, config: MapRunConfig, progress: Progress | None = None, truth: Path | None = None
) -> MapReport:
    """The intensity maps of one input."""
    return walked([named], IntensityMaps(config), out, truth, progress)


def fit_intensity_threshold(
    inputs: Sequence[Input], truth: Path | None, out: Path, config: ThresholdRunConfig
) -> FitReport:
    """The threshold that fits the inputs."""
    return walked(inputs, IntensityThreshold(config), out, truth)
