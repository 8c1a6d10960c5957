"""Intensity maps along a recording (MIM, section IV): from a sweep to its map."""

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import ClassVar

import numpy as np
from jaxtyping import Float64

from navtool.base.errors import DatasetsError
from navtool.base.note import Note
from navtool.base.plain import plain_fields
from navtool.methods.along.cell_scores import CellScores
from navtool.methods.along.goals import Goal
from navtool.methods.along.method import Method, Walked
from navtool.methods.along.observation import Observation, Skip
from navtool.methods.along.place_truth import PlaceTruth
from navtool.methods.along.streams import Streams
from navtool.methods.along.sweeps import Sweep, Sweeps
from navtool.methods.along.writers import Writer
from navtool.methods.intensity_map.config import MapRunConfig, SensorHeight
from navtool.methods.intensity_map.mapped import MappedSweep
from navtool.methods.intensity_map.outputs import OUTPUTS, MapOutputs
from navtool.methods.intensity_map.page import write_page
from navtool.methods.intensity_map.preflight import FIRST, judge_first, judged, nothing_mapped, threshold_notes
from navtool.methods.intensity_map.report import MapReport
from navtool.pipeline.arrays import Array
from navtool.pipeline.intensity_map.config import IntensityMapConfig
from navtool.pipeline.intensity_map.glass_memory import GlassMemory
from navtool.pipeline.intensity_map.layer_points import sort_points
from navtool.pipeline.intensity_map.mapper import IntensityMap, map_cloud
from navtool.pipeline.intensity_map.obstacles import CellClass
from navtool.pipeline.intensity_map.score import observed_cells

_PLANAR_M = 0.01
"""A cloud whose heights differ by less is that of a planar scanner."""


class IntensityMaps(Method[Sweep, MappedSweep, MapReport]):
    """Maps every sweep of a recording, and remembers glass from one to the next."""

    kind: ClassVar[str] = "navtool intensity maps"
    preview: ClassVar[int] = FIRST
    report_type = MapReport

    def __init__(self, config: MapRunConfig) -> None:
        self._config = config
        self.odometry_gap_s = config.sweeps.odometry_gap_s
        self.ticks = self._sweeps = Sweeps(config.sweeps)
        self._goal = Goal(config.goal)
        self.beside = (self._goal,)
        self._tally = _Tally()
        self._notes = threshold_notes(config)

    @property
    def settings(self) -> Mapping[str, object]:
        """The settings of the maps."""
        return plain_fields(self._config)

    def begin(self, streams: Streams, known: PlaceTruth | None, first: Sequence[Sweep]) -> None:
        """Judge the first intensities, and take the height of the sensor."""
        self._notes += judge_first(first, streams, self._config)
        self._mapper = _Mapper(*_with_height(streams, self._config))
        self._scores = None if known is None else CellScores(known, streams.base_lidar)
        self._topic = streams.topics["lidar"]

    def step(self, observation: Observation[Sweep]) -> MappedSweep | Skip:
        """The map of a sweep."""
        sweep = observation.reading
        fault = judged(sweep.intensity, self._config)
        if fault is not None:
            what = f"intensities: a cloud at {sweep.stamp_ns} ns is left out: {fault}"
            return Skip("intensities cannot be used", Note("intensities.unusable", what))
        mapped = self._mapper.map(sweep, observation[self._goal])
        self._tally.add(mapped)
        if self._scores is not None:
            grid = mapped.config.grid
            points = sort_points(sweep.xyz, sweep.intensity, grid, mapped.config.layers)
            self._scores.add(sweep, mapped.classes, observed_cells(points, grid), grid)
        return mapped

    def nothing(self, streams: Streams, walked: Walked) -> DatasetsError:
        """What is wrong where no cloud gives a map."""
        return nothing_mapped(streams, walked)

    def writers(self, folder: Path, streams: Streams) -> Sequence[Writer[MappedSweep]]:
        """Arrays, pictures, messages, a video and a table."""
        self._outputs = MapOutputs(folder, streams, self._sweeps, self._config.outputs)
        return self._outputs.writers

    def report(self, walked: Walked) -> MapReport:
        """The maps in figures."""
        mapper, tally, scores = self._mapper, self._tally, self._scores
        notes = [*walked.notes, *self._notes, *mapper.notes(), *walked.skip_notes, *tally.notes()]
        return MapReport(
            out=walked.out,
            source=walked.names[0],
            topic=self._topic,
            sensor=self._config.sensor,
            clouds=walked.ticks,
            maps=walked.results,
            duration_s=walked.duration_s,
            sensor_height_m=mapper.config.layers.sensor_height_m,
            height_from=mapper.height_from.value,
            skipped=dict(walked.unread + walked.skipped),
            points_dropped={reason: count for reason, count in tally.dropped.items() if count},
            without_odometry=mapper.alone,
            odometry_jumps=mapper.memory.jumps,
            cells={cell.name: int(tally.cells[cell]) for cell in CellClass},
            maps_with={cell.name: int(tally.maps_with[cell]) for cell in CellClass},
            scores={} if scores is None else scores.scores(),
            not_scored=0 if scores is None else scores.unplaced,
            files={name: walked.written.get(name, 0) for name in OUTPUTS},
            notes=[*notes, *([] if scores is None else scores.notes())],
        )

    def finish(self, folder: Path, report: MapReport) -> None:
        """Write the page."""
        write_page(folder / "index.html", report, self._config, self._outputs.moments)


class _Mapper:
    """Maps sweeps one after the other with what is remembered of glass."""

    def __init__(self, config: IntensityMapConfig, height_from: SensorHeight) -> None:
        self.config, self.height_from = config, height_from
        self.memory = GlassMemory()
        self.alone = 0
        self._number = 0
        self.planar = 0
        self._planar_config = replace(self.config, layers=replace(self.config.layers, ground_margin_m=0.0))

    def map(self, sweep: Sweep, goal_rad: float) -> MappedSweep:
        """The map of the next sweep; one that odometry does not place stands alone."""
        config = self.config
        if np.ptp(sweep.xyz[:, 2]) < _PLANAR_M:
            self.planar += 1
            config = self._planar_config
        if sweep.odom_sensor is None:
            self.alone += 1
            # without odometry there is no second look at the same place
            once = replace(config, glass=replace(config.glass, clouds=1))
            _, made = self._mapped(GlassMemory(), sweep, np.zeros(3), goal_rad, once)
        else:
            self.memory, made = self._mapped(self.memory, sweep, sweep.odom_sensor, goal_rad, config)
        self._number += 1
        return MappedSweep(self._number - 1, sweep, made, goal_rad, config)

    def notes(self) -> list[Note]:
        """What a user should look at."""
        notes = []
        if self.height_from is SensorHeight.setting:
            height = f"map.layers.sensor_height_m = {self.config.layers.sensor_height_m:g} m"
            notes.append(Note("height.as-set", f"height of the sensor above the ground: {height}, as set"))
        if self.planar:
            what = f"{self.planar} clouds lie in one level plane, which shows no ground: none is cut away there"
            notes.append(Note("lidar.level-planes", what))
        if self.alone:
            left = "" if self._number == self.alone else f" for {self.alone} clouds"
            what = f"odometry does not tell the sensor's place{left}: each of these maps stands alone"
            what = f"{what}, glass counts where one cloud shows it, and the goal is straight on"
            notes.append(Note("odometry.no-place", what))
        if self.memory.jumps:
            jumps = f"odometry: {self.memory.jumps} jumps of more than {self.config.glass.jump_m:g} m or back in time"
            notes.append(Note("odometry.jumps", f"{jumps}; all glass known until then was forgotten"))
        return notes

    @staticmethod
    def _mapped(
        memory: GlassMemory, sweep: Sweep, place: Float64[Array, "3"], goal_rad: float, config: IntensityMapConfig
    ) -> tuple[GlassMemory, IntensityMap]:
        return map_cloud(memory, sweep.xyz, sweep.intensity, place, sweep.stamp_ns * 1e-9, goal_rad, config)


class _Tally:
    """Counts what the maps show."""

    def __init__(self) -> None:
        self.dropped: Counter[str] = Counter()
        self.cells = np.zeros(len(CellClass), np.int64)
        self.maps_with = np.zeros(len(CellClass), np.int64)

    def add(self, mapped: MappedSweep) -> None:
        """Count a map."""
        self.dropped.update({name.replace("_", " "): count for name, count in mapped.sweep.drops._asdict().items()})
        cells = np.bincount(mapped.classes.reshape(-1), minlength=len(CellClass))
        self.cells += cells
        self.maps_with += cells > 0

    def notes(self) -> list[Note]:
        """What a user should look at."""
        if self.cells[1:].any():
            return []
        what = "no point of any cloud lies in a layer of its map"
        cure = "look at the sensor's height and mounting, map.grid and map.layers"
        return [Note("map.empty", f"{what}: {cure}")]


def _with_height(streams: Streams, config: MapRunConfig) -> tuple[IntensityMapConfig, SensorHeight]:
    height_m = streams.lidar_height_m
    if config.sensor_height is SensorHeight.setting or height_m is None or not math.isfinite(height_m):
        return config.map, SensorHeight.setting
    return replace(config.map, layers=replace(config.map.layers, sensor_height_m=height_m)), SensorHeight.calibration
