"""The intensity maps of a run, from its clouds to the files (MIM, section IV)."""

import math
import time
from collections import Counter
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
from jaxtyping import Float64

from navtool.base.background import Background
from navtool.base.lineage import file_sha256
from navtool.base.output_folder import OutputFolder
from navtool.base.progress import Progress
from navtool.methods.along.goals import goal_direction
from navtool.methods.along.place_truth import PlaceTruth, find_truth
from navtool.methods.along.source import MapInput
from navtool.methods.along.sweeps import Sweep, SweepSource
from navtool.methods.intensity_map.config import MapRunConfig, SensorHeight
from navtool.methods.intensity_map.mapped import MappedSweep
from navtool.methods.intensity_map.outputs import Outputs
from navtool.methods.intensity_map.page import write_page
from navtool.methods.intensity_map.preflight import judged, judged_first, nothing_mapped, threshold_notes
from navtool.methods.intensity_map.report import MapReport
from navtool.methods.intensity_map.scoring import Scoring
from navtool.pipeline.arrays import Array
from navtool.pipeline.intensity_map.config import IntensityMapConfig
from navtool.pipeline.intensity_map.glass_memory import GlassMemory
from navtool.pipeline.intensity_map.mapper import IntensityMap, map_cloud
from navtool.pipeline.intensity_map.obstacles import CellClass

_PLANAR_M = 0.01
"""A cloud whose heights differ by less is that of a planar scanner."""
KIND = "navtool intensity maps"
"""What a lineage calls the output."""


def intensity_maps(
    chosen: MapInput, out: Path, config: MapRunConfig, progress: Progress, truth: Path | None = None
) -> MapReport:
    """Map an input, unless its maps lie in the folder already.

    Args:
        chosen: A recording, or an episode of a data set.
        out: A folder that is not there, is empty, or holds the maps of the same input and settings.
        config: Everything that decides the maps.
        progress: Is told how many clouds are done.
        truth: Annotations in the frame of the odometry, to score the maps; simulated recordings bring their own.

    Raises:
        DatasetsError: The input cannot be read or mapped, with the reason, or the folder holds something else.
        OutputError: The folder cannot be written.
    """
    OutputFolder(out, KIND).refuse_other()
    identity = {**chosen.identity(config), "truth": None if truth is None else file_sha256(truth)}
    folder = OutputFolder(out, KIND, identity)
    if (before := folder.finished(MapReport)) is not None:
        return replace(before, done_before=True)
    known = find_truth(chosen, truth, config.sweeps.odometry_gap_s)
    with chosen.open(config) as source:
        return map_run(source, folder, config, chosen.about(), progress, known)


def map_run(
    source: SweepSource,
    folder: OutputFolder,
    config: MapRunConfig,
    about: Mapping[str, object],
    progress: Progress,
    known: PlaceTruth | None = None,
) -> MapReport:
    """Map every cloud of a run and write what the settings ask for; the folder is there whole, or not.

    Memory does not grow with the run. Drawing, compressing and writing are done in a thread beside.

    Args:
        source: The run.
        folder: It is not there, or empty.
        config: Everything that decides the maps.
        about: What else is known of the input; written last, with the report.
        progress: Is told how many clouds are done.
        known: What stands there, to score the maps; None where nobody knows.

    Raises:
        DatasetsError: Nothing can be mapped, with the reason; nothing is written then.
        OutputError: It cannot be written.
    """
    begun = time.monotonic()
    progress.begin(1, source.clouds)
    sweeps, notes = judged_first(source, config)
    mapper = _Mapper(source, config)
    tally = _Tally(config)
    scoring = None if known is None else Scoring(known.in_odometry(source), source.base_lidar)
    with folder.staged() as staging:
        # the thread beside is left before the files that it writes to are closed
        with Outputs(staging, source, config) as outputs, Background() as beside:
            for sweep in sweeps:
                if tally.takes(sweep):
                    mapped = mapper.map(sweep)
                    tally.add(mapped)
                    if scoring is not None:
                        scoring.add(mapped)
                    beside.call(outputs.add, mapped)
                progress.advance(1, 0)
            if not tally.maps:
                raise nothing_mapped(source, tally.skipped)
            beside.call(outputs.finish)
        report = MapReport(
            out=folder.root.as_posix(),
            source=source.name,
            topic=source.topic,
            sensor=config.sensor,
            clouds=source.clouds,
            maps=tally.maps,
            duration_s=source.duration_s,
            sensor_height_m=mapper.config.layers.sensor_height_m,
            height_from=mapper.height_from.value,
            skipped=dict(source.skipped + tally.skipped),
            points_dropped={reason: count for reason, count in tally.dropped.items() if count},
            without_odometry=mapper.alone,
            odometry_jumps=mapper.memory.jumps,
            cells={cell.name: int(tally.cells[cell]) for cell in CellClass},
            maps_with={cell.name: int(tally.maps_with[cell]) for cell in CellClass},
            scores={} if scoring is None else scoring.scores(),
            not_scored=0 if scoring is None else scoring.unplaced,
            files=outputs.written,
            notes=[
                *source.notes,
                *threshold_notes(config),
                *notes,
                *mapper.notes(),
                *tally.told(),
                *([] if scoring is None else scoring.notes()),
            ],
        )
        write_page(staging / "index.html", report, config, outputs.moments)
        folder.write_record(staging, about, report)
    progress.advance(0, source.clouds - tally.maps - tally.skipped.total())
    progress.done(1, source.name)
    return replace(report, seconds=time.monotonic() - begun)


class _Mapper:
    """Maps sweeps one after the other with what is remembered of glass."""

    def __init__(self, source: SweepSource, config: MapRunConfig) -> None:
        self.config, self.height_from = _with_height(source, config)
        self.memory = GlassMemory()
        self.alone = 0
        self._number = 0
        self._source, self._goal = source, config.goal
        self.planar = 0
        self._planar_config = replace(self.config, layers=replace(self.config.layers, ground_margin_m=0.0))

    def map(self, sweep: Sweep) -> MappedSweep:
        """The map of the next sweep; one that odometry does not place stands alone."""
        goal_rad = goal_direction(self._source.motion, sweep.stamp_ns, sweep.odom_sensor, self._goal)
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

    def notes(self) -> list[str]:
        """What a user should look at."""
        notes = []
        if self.height_from is SensorHeight.setting:
            height = f"map.layers.sensor_height_m = {self.config.layers.sensor_height_m:g} m"
            notes.append(f"height of the sensor above the ground: {height}, as set")
        if self.planar:
            notes.append(f"{self.planar} clouds lie in one level plane, which shows no ground: none is cut away there")
        if self.alone:
            left = "" if self._number == self.alone else f" for {self.alone} clouds"
            what = f"odometry does not tell the sensor's place{left}: each of these maps stands alone"
            notes.append(f"{what}, glass counts where one cloud shows it, and the goal is straight on")
        if self.memory.jumps:
            jumps = f"odometry: {self.memory.jumps} jumps of more than {self.config.glass.jump_m:g} m or back in time"
            notes.append(f"{jumps}; all glass known until then was forgotten")
        return notes

    @staticmethod
    def _mapped(
        memory: GlassMemory, sweep: Sweep, place: Float64[Array, "3"], goal_rad: float, config: IntensityMapConfig
    ) -> tuple[GlassMemory, IntensityMap]:
        return map_cloud(memory, sweep.xyz, sweep.intensity, place, sweep.stamp_ns * 1e-9, goal_rad, config)


class _Tally:
    """Counts what the maps show and what did not come to be one."""

    def __init__(self, config: MapRunConfig) -> None:
        self._config = config
        self.maps = 0
        self.skipped: Counter[str] = Counter()
        self.dropped: Counter[str] = Counter()
        self.cells = np.zeros(len(CellClass), np.int64)
        self.maps_with = np.zeros(len(CellClass), np.int64)
        self.notes: list[str] = []

    def takes(self, sweep: Sweep) -> bool:
        """Whether a sweep's intensities can be used; counts it where not."""
        fault = judged(sweep.intensity, self._config)
        if fault is None:
            return True
        self.skipped["intensities cannot be used"] += 1
        if not self.notes:
            self.notes.append(f"intensities: a cloud at {sweep.stamp_ns} ns is left out: {fault}")
        return False

    def add(self, mapped: MappedSweep) -> None:
        """Count a map."""
        self.maps += 1
        self.dropped.update({name.replace("_", " "): count for name, count in mapped.sweep.drops._asdict().items()})
        cells = np.bincount(mapped.classes.reshape(-1), minlength=len(CellClass))
        self.cells += cells
        self.maps_with += cells > 0

    def told(self) -> list[str]:
        """What a user should look at."""
        if self.cells[1:].any():
            return self.notes
        what = "no point of any cloud lies in a layer of its map"
        return [*self.notes, f"{what}: look at the sensor's height and mounting, map.grid and map.layers"]


def _with_height(source: SweepSource, config: MapRunConfig) -> tuple[IntensityMapConfig, SensorHeight]:
    height_m = source.sensor_height_m
    if config.sensor_height is SensorHeight.setting or height_m is None or not math.isfinite(height_m):
        return config.map, SensorHeight.setting
    return replace(config.map, layers=replace(config.map.layers, sensor_height_m=height_m)), SensorHeight.calibration
