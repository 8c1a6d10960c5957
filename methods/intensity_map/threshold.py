"""The threshold fitted along recordings: from the sweeps of all inputs to the settings."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import ClassVar, override

import numpy as np
import yaml
from jaxtyping import UInt8

from navtool.base.errors import DatasetsError
from navtool.base.files import write_bytes
from navtool.base.note import Note
from navtool.base.plain import plain_fields
from navtool.methods.along.method import Method, Walked
from navtool.methods.along.observation import Observation, Skip
from navtool.methods.along.place_truth import PlaceTruth
from navtool.methods.along.streams import Streams
from navtool.methods.along.sweeps import Sweep, Sweeps
from navtool.methods.intensity_map.config import SensorHeight, SensorMapConfig
from navtool.methods.intensity_map.fit_report import FitReport, doubts, tried
from navtool.methods.intensity_map.fit_threshold import ThresholdFit, ThresholdFitConfig, ThresholdFitter
from navtool.methods.intensity_map.ground_height import height_above_ground
from navtool.methods.intensity_map.preflight import FIRST, judge_first, judged, nothing_mapped
from navtool.methods.intensity_map.roc_picture import roc_picture
from navtool.pipeline.arrays import Array
from navtool.pipeline.intensity_map.config import LayerConfig, Reduction

SETTINGS, PICTURE = "settings.yaml", "roc.svg"
"""What lies in the output beside its lineage."""
_HEIGHT_SWEEPS = 10
"""Sweeps from whose ground the height of a sensor is measured, where it is not known."""


@dataclass(kw_only=True, slots=True)
class ThresholdRunConfig(SensorMapConfig):
    """The sensor's maps, and what is tried on them."""

    tried: ThresholdFitConfig = field(default_factory=ThresholdFitConfig)
    """Heights, and on how many sweeps."""


class IntensityThreshold(Method[Sweep, None, FitReport]):
    """Finds the threshold and the heights that tell solid cells best, from sweeps of all inputs."""

    kind: ClassVar[str] = "navtool intensity threshold"
    preview: ClassVar[int] = FIRST
    several: ClassVar[bool] = True
    needs_truth: ClassVar[bool] = True
    report_type = FitReport

    def __init__(self, config: ThresholdRunConfig) -> None:
        self._config = config
        self.odometry_gap_s = config.sweeps.odometry_gap_s
        self.ticks = Sweeps(config.sweeps)
        self._fitter = ThresholdFitter(config.map, config.tried)
        self._heights_m: list[float] = []
        self._notes: list[Note] = []

    @property
    def settings(self) -> Mapping[str, object]:
        """The sensor, and what is tried."""
        return plain_fields(self._config)

    def begin(self, streams: Streams, known: PlaceTruth | None, first: Sequence[Sweep]) -> None:
        """Judge the first intensities of an input."""
        if known is None:
            raise TypeError("a fit needs the truth")
        self._known, self._base_lidar = known, streams.base_lidar
        self._judged = judge_first(first, streams, self._config)
        self._ground = _Ground(streams.lidar_height_m, self._config)
        self._waiting: list[tuple[Sweep, UInt8[Array, "n n"]]] = []
        self._following_ns: int | None = None

    def step(self, observation: Observation[Sweep]) -> Skip | None:
        """Look at a sweep, where the last one lies far enough back."""
        sweep = observation.reading
        if not self._wanted(sweep.stamp_ns):
            return None
        self._ground.look(sweep)
        if judged(sweep.intensity, self._config) is not None:
            return Skip("intensities cannot be used")
        truth = self._known.classes_around(sweep, self._base_lidar, self._config.map.grid)
        if truth is None:
            return Skip("the robot's place among the outlines is not known")
        self._waiting.append((sweep, truth))
        if self._ground.sure:
            self._add_waiting()
        return None

    @override
    def end(self, streams: Streams, walked: Walked) -> None:
        """Look at the sweeps that are left, and keep what a user should look at in the input."""
        self._add_waiting()
        height_m, how = self._ground.height()
        self._heights_m.append(height_m)
        self._notes += [note.about(streams.name) for note in [*streams.notes, *self._judged, *how]]

    def nothing(self, streams: Streams, walked: Walked) -> DatasetsError:
        """What is wrong where no cloud can be read."""
        return nothing_mapped(streams, walked)

    def report(self, walked: Walked) -> FitReport:
        """The fit in figures."""
        self._fit = fit = self._fitter.fit()
        return FitReport(
            out=walked.out,
            inputs=walked.names,
            settings=fit.settings(),
            tried=tried(fit),
            sweeps=fit.sweeps,
            cells=fit.cells,
            sensor_heights_m=self._heights_m,
            skipped=dict(walked.skipped + walked.unread),
            notes=[*self._notes, *doubts(fit, self._config.tried)],
        )

    def finish(self, folder: Path, report: FitReport) -> None:
        """Write the settings, and the curves as a picture."""
        write_bytes(folder / SETTINGS, settings_text(self._fit, self._config, report.inputs).encode())
        unit = "R per square metre" if self._config.map.layers.reduction is Reduction.sum else "R"
        write_bytes(folder / PICTURE, roc_picture(self._fit, unit).encode())

    def _wanted(self, stamp_ns: int) -> bool:
        """Whether a sweep lies far enough behind the last one that was looked at."""
        every_ns, following_ns = round(self._config.tried.every_s * 1e9), self._following_ns
        if following_ns is not None and following_ns - every_ns <= stamp_ns < following_ns:
            return False
        self._following_ns = stamp_ns + every_ns
        return True

    def _add_waiting(self) -> None:
        height_m, _ = self._ground.height()
        for sweep, truth in self._waiting:
            self._fitter.add(sweep, truth, height_m)
        self._waiting.clear()


class _Ground:
    """The height of the sensor above the ground, measured in the first sweeps where it is not known otherwise."""

    def __init__(self, known_m: float | None, config: SensorMapConfig) -> None:
        self._layers: LayerConfig = config.map.layers
        self._known_m = self._layers.sensor_height_m if config.sensor_height is SensorHeight.setting else known_m
        self._measured: list[float] = []
        self._seen = 0

    @property
    def sure(self) -> bool:
        """Whether no further sweep will change it."""
        return self._seen >= _HEIGHT_SWEEPS

    def look(self, sweep: Sweep) -> None:
        """Measure it in a sweep, as long as that counts."""
        if self._known_m is None and not self.sure and (height := height_above_ground(sweep.xyz)) is not None:
            self._measured.append(height)
        self._seen += 1

    def height(self) -> tuple[float, list[Note]]:
        """In metres, and what a user should know of it."""
        if self._known_m is not None:
            return self._known_m, []
        height_m = round(float(np.median(self._measured)), 3) if self._measured else 0.0
        if height_m <= 0:
            set_m = self._layers.sensor_height_m
            what = f"no ground was seen: {set_m:g} m is taken for the height"
            return set_m, [Note("height.no-ground", what)]
        how = f"the sensor is {height_m:g} m above the ground, as {len(self._measured)} sweeps show: for maps, set "
        return height_m, [Note("height.measured", f"{how}map.layers.sensor_height_m={height_m:g}")]


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
