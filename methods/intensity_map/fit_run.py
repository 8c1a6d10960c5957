"""Fitting the threshold to recordings, from their clouds to the files."""

import time
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain, islice
from pathlib import Path

import numpy as np
import yaml

from navtool.base.errors import DatasetsError
from navtool.base.files import write_bytes
from navtool.base.lineage import code_version, config_hash, file_sha256
from navtool.base.output_folder import OutputFolder
from navtool.base.progress import Progress
from navtool.methods.along.place_truth import TRUTH_CURE, PlaceTruth, find_truth
from navtool.methods.along.source import MapInput
from navtool.methods.along.sweeps import Sweep, SweepSource
from navtool.methods.intensity_map.config import SensorHeight, SensorMapConfig
from navtool.methods.intensity_map.fit_report import FitReport, doubts, tried
from navtool.methods.intensity_map.fit_threshold import ThresholdFit, ThresholdFitConfig, ThresholdFitter
from navtool.methods.intensity_map.ground_height import height_above_ground
from navtool.methods.intensity_map.preflight import judged, judged_first
from navtool.methods.intensity_map.roc_picture import roc_picture
from navtool.pipeline.intensity_map.config import LayerConfig, Reduction

KIND = "navtool intensity threshold"
"""What a lineage calls the output."""
SETTINGS, PICTURE = "settings.yaml", "roc.svg"
"""What lies in the output beside its lineage."""
_HEIGHT_SWEEPS = 10
"""Sweeps whose ground tells the height of a sensor, where nobody has told it."""
_SHARES = 1000
"""In how many parts the progress of one input is told."""


@dataclass(kw_only=True, slots=True)
class ThresholdRunConfig(SensorMapConfig):
    """The sensor's maps, and what is tried on them."""

    tried: ThresholdFitConfig = field(default_factory=ThresholdFitConfig)
    """Heights, and on how many sweeps."""


def fit_intensity_threshold(
    inputs: Sequence[MapInput], truth: Path | None, out: Path, config: ThresholdRunConfig, progress: Progress
) -> FitReport:
    """Find the threshold and the heights that tell solid cells best, unless they lie in the folder already.

    Args:
        inputs: Recordings, or episodes of data sets; one at least.
        truth: Annotations in the frame of the odometry, of all inputs; None where each input brings its own, as
            simulated recordings do.
        out: A folder that is not there, is empty, or holds the fit of the same inputs and settings.
        config: The sensor, and what is tried.
        progress: Is told how many inputs are done.

    Raises:
        DatasetsError: An input cannot be read or mapped, nothing says what stands there, nothing solid or nothing
            pliable was seen, or the folder holds something else.
        OutputError: The folder cannot be written.
    """
    OutputFolder(out, KIND).refuse_other()
    each = [chosen.identity(config) for chosen in inputs]
    identity: dict[str, object] = {
        "inputs": [one["input"] for one in each],
        "truth": None if truth is None else file_sha256(truth),
        "settings": config_hash([one["settings"] for one in each]),
        "code_version": code_version(),
    }
    folder = OutputFolder(out, KIND, identity)
    if (before := folder.finished(FitReport)) is not None:
        return replace(before, done_before=True)
    begun = time.monotonic()
    run = _Run(config)
    progress.begin(len(inputs), _SHARES * len(inputs))
    for number, chosen in enumerate(inputs, 1):
        known = find_truth(chosen, truth, config.sweeps.odometry_gap_s)
        if known is None:
            raise DatasetsError("nothing says what stands there", where=chosen.path, cure=TRUTH_CURE)
        with chosen.open(config) as source:
            run.look_at(source, known, progress)
        progress.done(number, source.name)
    fit = run.fitter.fit()
    report = run.report(fit, out)
    with folder.staged() as staging:
        write_bytes(staging / SETTINGS, settings_text(fit, config, report.inputs).encode())
        unit = "R per square metre" if config.map.layers.reduction is Reduction.sum else "R"
        write_bytes(staging / PICTURE, roc_picture(fit, unit).encode())
        folder.write_record(staging, [chosen.about() for chosen in inputs], report)
    return replace(report, seconds=time.monotonic() - begun)


def settings_text(fit: ThresholdFit, config: SensorMapConfig, names: Sequence[str]) -> str:
    """YAML that ``navtool intensity-map --settings`` takes: what was fitted, and what it holds for alone."""
    layers, obstacles = config.map.layers, config.map.obstacles
    found = fit.settings()
    content = {
        "sensor": config.sensor,
        "largest_intensity": config.largest_intensity,
        "map": {
            "grid": {"cell_m": config.map.grid.cell_m},
            "layers": {
                "full_scale": layers.full_scale,
                "reduction": layers.reduction.value,
                "flat": layers.flat.value,
                "flat_rad": layers.flat_rad,
                "flat_m": layers.flat_m,
                "height_m": found["layers.height_m"],
                "ground_margin_m": found["layers.ground_margin_m"],
            },
            "obstacles": {"threshold": found["obstacles.threshold"], "pooling_cells": obstacles.pooling_cells},
        },
    }
    head = f"# fitted by navtool fit intensity_threshold to {', '.join(names)}\n"
    return head + yaml.safe_dump(content, sort_keys=False, allow_unicode=True, width=120)


class _Run:
    """Looks at inputs one after the other."""

    def __init__(self, config: ThresholdRunConfig) -> None:
        self.fitter = ThresholdFitter(config.map, config.tried)
        self._config = config
        self._names: list[str] = []
        self._heights_m: list[float] = []
        self._skipped: Counter[str] = Counter()
        self._notes: list[str] = []

    def look_at(self, source: SweepSource, known: PlaceTruth, progress: Progress) -> None:
        known = known.in_odometry(source)
        sweeps, notes = judged_first(source, self._config)
        told = _Shares(progress, source.clouds)
        chosen = self._sampled(sweeps, told)
        first = list(islice(chosen, _HEIGHT_SWEEPS))
        height_m, how = _height(source, first, self._config)
        for sweep in chain(first, chosen):
            if judged(sweep.intensity, self._config) is not None:
                self._skipped["intensities cannot be used"] += 1
                continue
            truth = known.classes_around(sweep, source.base_lidar, self._config.map.grid)
            if truth is None:
                self._skipped["the robot's place among the outlines is not known"] += 1
                continue
            self.fitter.add(sweep, truth, height_m)
        told.all()
        self._names.append(source.name)
        self._heights_m.append(height_m)
        self._skipped += source.skipped
        self._notes += [f"{source.name}: {note}" for note in [*source.notes, *notes, how] if note]

    def report(self, fit: ThresholdFit, out: Path) -> FitReport:
        return FitReport(
            out=out.as_posix(),
            inputs=self._names,
            settings=fit.settings(),
            tried=tried(fit),
            sweeps=fit.sweeps,
            cells=fit.cells,
            sensor_heights_m=self._heights_m,
            skipped=dict(self._skipped),
            notes=[*self._notes, *doubts(fit, self._config.tried)],
        )

    def _sampled(self, sweeps: Iterator[Sweep], told: "_Shares") -> Iterator[Sweep]:
        every_ns, following_ns = round(self._config.tried.every_s * 1e9), None
        for sweep in sweeps:
            told.one()
            if following_ns is None or not following_ns - every_ns <= sweep.stamp_ns < following_ns:
                following_ns = sweep.stamp_ns + every_ns
                yield sweep


class _Shares:
    """Tells the progress through one input in parts of its clouds."""

    def __init__(self, progress: Progress, clouds: int) -> None:
        self._progress, self._clouds = progress, max(clouds, 1)
        self._seen, self._told = 0, 0

    def one(self) -> None:
        self._seen += 1
        self._tell(min(_SHARES * self._seen // self._clouds, _SHARES))

    def all(self) -> None:
        self._tell(_SHARES)

    def _tell(self, share: int) -> None:
        self._progress.advance(share - self._told, 0)
        self._told = share


def _height(source: SweepSource, sweeps: Sequence[Sweep], config: SensorMapConfig) -> tuple[float, str]:
    """The height of the sensor above the ground, and what a user should know of it."""
    layers: LayerConfig = config.map.layers
    if config.sensor_height is SensorHeight.setting:
        return layers.sensor_height_m, ""
    if source.sensor_height_m is not None:
        return source.sensor_height_m, ""
    measured = [height for sweep in sweeps if (height := height_above_ground(sweep.xyz)) is not None]
    if not measured:
        return layers.sensor_height_m, f"no ground was seen: {layers.sensor_height_m:g} m is taken for the height"
    height_m = round(float(np.median(measured)), 3)
    how = f"the sensor is {height_m:g} m above the ground, as {len(measured)} sweeps show: for maps, set "
    return height_m, f"{how}map.layers.sensor_height_m={height_m:g}"
