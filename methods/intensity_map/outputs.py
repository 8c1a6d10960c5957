"""The files of a run's maps, each of as many as the settings ask for."""

from contextlib import ExitStack
from fractions import Fraction
from pathlib import Path
from types import TracebackType
from typing import NamedTuple

from navtool.methods.along.sweeps import SweepSource
from navtool.methods.along.video import MapVideo
from navtool.methods.intensity_map.arrays import ArrayWriter
from navtool.methods.intensity_map.config import MapRunConfig
from navtool.methods.intensity_map.mapped import MappedSweep
from navtool.methods.intensity_map.mcap_file import MapMcap
from navtool.methods.intensity_map.pictures import PictureWriter, draw_map, png_bytes
from navtool.methods.intensity_map.table import MapTable

VIDEO = "map.mp4"
MOMENTS = 9
"""Pictures on the page."""
_RATE_HZ = (1, 60)


class Moment(NamedTuple):
    """A picture for the page."""

    seconds: float
    """Since the first map."""
    png: bytes


class Outputs:
    """Writes arrays, pictures, messages, a video and a table of maps into a folder, and keeps pictures for the page.

    Use it as a context manager, and call ``finish`` when all maps are there.

    Attributes:
        written: How many maps each output holds.
        moments: Pictures from all over the run.
    """

    def __init__(self, folder: Path, source: SweepSource, config: MapRunConfig) -> None:
        every = config.outputs
        self._every = every
        self._files = ExitStack()
        self._arrays = ArrayWriter(folder / "arrays") if every.arrays_every else None
        self._pictures = PictureWriter(folder / "pictures") if every.pictures_every else None
        self._mcap = self._files.enter_context(MapMcap(folder / "maps.mcap")) if every.mcap_every else None
        self._video = None
        if every.video_every:
            self._video = self._files.enter_context(MapVideo(folder / VIDEO, _rate(source, every.video_every)))
        self._table = MapTable(folder / "maps.csv")
        self._moment_every = max(1, source.clouds // MOMENTS)
        self._first_ns: int | None = None
        self.written = {"arrays": 0, "pictures": 0, "mcap": 0, "video": 0}
        self.moments: list[Moment] = []

    def add(self, mapped: MappedSweep) -> None:
        """Write a map into the outputs that want it."""
        self._first_ns = mapped.sweep.stamp_ns if self._first_ns is None else self._first_ns
        seconds = (mapped.sweep.stamp_ns - self._first_ns) * 1e-9
        self._table.add(mapped)
        if self._arrays is not None and self._wanted("arrays", mapped, self._every.arrays_every):
            self._arrays.add(mapped)
        png = self._drawn(mapped, seconds)
        if self._mcap is not None and self._wanted("mcap", mapped, self._every.mcap_every):
            self._mcap.add(mapped, png)

    def finish(self) -> None:
        """Write what is left."""
        self._table.write()

    def _drawn(self, mapped: MappedSweep, seconds: float) -> bytes | None:
        """Draw a map once for all that show it; its PNG where there is one."""
        in_video = self._video is not None and self._wanted("video", mapped, self._every.video_every)
        in_pictures = self._pictures is not None and self._wanted("pictures", mapped, self._every.pictures_every)
        on_page = mapped.number % self._moment_every == 0 and len(self.moments) < MOMENTS
        if not (in_video or in_pictures or on_page):
            return None
        sheet = draw_map(mapped, seconds)
        if in_video and self._video is not None:
            self._video.add(sheet)
        if not (in_pictures or on_page):
            return None
        png = png_bytes(sheet)
        if in_pictures and self._pictures is not None:
            self._pictures.add(mapped.number, png)
        if on_page:
            self.moments.append(Moment(seconds, png))
        return png

    def _wanted(self, name: str, mapped: MappedSweep, every: int) -> bool:
        wanted = mapped.number % every == 0
        self.written[name] += wanted
        return wanted

    def __enter__(self) -> "Outputs":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._files.__exit__(kind, error, trace)


def _rate(source: SweepSource, every: int) -> Fraction:
    """The video's rate, at which it lasts about as long as the run."""
    usual = (source.clouds - 1) / source.duration_s / every if source.duration_s > 0 else 1.0
    return Fraction(min(max(usual, _RATE_HZ[0]), _RATE_HZ[1])).limit_denominator(10)
