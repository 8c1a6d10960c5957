"""The files of maps, each of as many as the settings ask for."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from jaxtyping import UInt8

from navtool.methods.along.array_files import ArrayFiles
from navtool.methods.along.csv_file import CsvFile
from navtool.methods.along.mcap_file import McapFile
from navtool.methods.along.pictures import Drawn, Moment, Moments, PictureFiles
from navtool.methods.along.streams import Streams
from navtool.methods.along.sweeps import Sweeps
from navtool.methods.along.video import VideoFile, rate_of
from navtool.methods.along.writers import Outcome, Selection, Writer
from navtool.methods.intensity_map.arrays import map_arrays
from navtool.methods.intensity_map.config import OutputConfig
from navtool.methods.intensity_map.mapped import MappedSweep
from navtool.methods.intensity_map.messages import MapMessages
from navtool.methods.intensity_map.page import VIDEO
from navtool.methods.intensity_map.pictures import draw_map
from navtool.pipeline.arrays import Array
from navtool.pipeline.intensity_map.obstacles import CellClass

OUTPUTS = ("arrays", "pictures", "mcap", "video")
"""What may be written, in the order of reports."""
_COLUMNS = ("map", "stamp_ns", "x_m", "y_m", "yaw_rad", "goal_rad", "points", *(f"{x.name}_cells" for x in CellClass))


class MapOutputs:
    """What writes the maps of one input into a folder."""

    def __init__(self, folder: Path, streams: Streams, ticks: Sweeps, every: OutputConfig) -> None:
        drawn = Drawn(_draw)
        count = ticks.count(streams)
        self._drawn, self._pictures = drawn, Selection(every.pictures_every) if every.pictures_every else None
        self._moments = Moments(drawn, count)
        writers: list[Writer[MappedSweep]] = [CsvFile(folder / "maps.csv", _COLUMNS, map_line)]
        if every.arrays_every:
            writers.append(ArrayFiles(folder / "arrays", map_arrays, Selection(every.arrays_every)))
        if every.video_every:
            rate_hz = rate_of(count, ticks.duration_s(streams), every.video_every)
            writers.append(VideoFile(folder / VIDEO, drawn, Selection(every.video_every), rate_hz))
        if self._pictures is not None:
            writers.append(PictureFiles(folder / "pictures", drawn, self._pictures))
        writers.append(self._moments)
        if every.mcap_every:
            writers.append(McapFile(folder / "maps.mcap", MapMessages(self._picture), Selection(every.mcap_every)))
        self.writers: Sequence[Writer[MappedSweep]] = writers

    @property
    def moments(self) -> list[Moment]:
        """Pictures for the page."""
        return self._moments.kept

    def _picture(self, outcome: Outcome[MappedSweep]) -> bytes | None:
        """The picture of a map that is written, or on the page, for the messages too."""
        chosen = (self._pictures, self._moments.selection)
        shown = any(one is not None and one.takes(outcome.number) for one in chosen)
        return self._drawn.png(outcome) if shown else None


def map_line(outcome: Outcome[MappedSweep]) -> Sequence[object]:
    """When, where, and what a map shows; a place that is not known is empty."""
    mapped = outcome.result
    place = mapped.sweep.odom_sensor
    cells = np.bincount(mapped.classes.reshape(-1), minlength=len(CellClass)).tolist()
    at = [None] * 3 if place is None else [f"{value:.4f}" for value in place.tolist()]
    points = int(mapped.map.layers.points.sum())
    return [outcome.number, outcome.stamp_ns, *at, f"{mapped.goal_rad:.4f}", points, *cells]


def _draw(outcome: Outcome[MappedSweep]) -> UInt8[Array, "h w 3"]:
    return draw_map(outcome.result, outcome.seconds)
