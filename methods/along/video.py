"""Pictures of results along a recording, as a video."""

from fractions import Fraction
from pathlib import Path
from types import TracebackType

import av
import cv2
import numpy as np
from jaxtyping import UInt8

from navtool.methods.along.pictures import Drawn
from navtool.methods.along.writers import Outcome, Selection, Writer
from navtool.pipeline.arrays import Array

_RATE_HZ = (1, 60)


class VideoFile[R](Writer[R]):
    """Shows the pictures of results one after the other."""

    def __init__(self, path: Path, drawn: Drawn[R], selection: Selection, rate_hz: Fraction) -> None:
        super().__init__("video", selection)
        self._drawn, self._stream = drawn, VideoStream(path, rate_hz)

    def write(self, outcome: Outcome[R]) -> None:
        """Show a result's picture next."""
        self._stream.add(self._drawn.sheet(outcome))

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._stream.__exit__(kind, error, trace)


def rate_of(ticks: int, duration_s: float, every: int) -> Fraction:
    """The rate in Hz at which a video lasts about as long as the recording, within 1 to 60.

    Args:
        ticks: Of the recording.
        duration_s: From the first to the last.
        every: One picture for so many ticks.
    """
    usual = (ticks - 1) / duration_s / every if duration_s > 0 else 1.0
    return Fraction(min(max(usual, _RATE_HZ[0]), _RATE_HZ[1])).limit_denominator(10)


class VideoStream:
    """Encodes pictures as H.264 at a fixed rate; browsers and players open it.

    The same pictures give the same bytes on the same build of the codec. Use it as a context manager; leaving it
    without an error finishes the file.
    """

    def __init__(self, path: Path, rate_hz: Fraction) -> None:
        # opened here: FFmpeg does not let go of a file of its own that it could not begin to write
        self._file = path.open("wb", buffering=0)
        self._container = av.open(self._file, "w", format="mp4")
        self._rate_hz = rate_hz
        self._stream: av.VideoStream | None = None
        self._frames = 0
        self._whole = True
        """Whether all could be written so far: FFmpeg crashes where a file that could not begin is written on."""

    def add(self, sheet: UInt8[Array, "h w 3"]) -> None:
        """Encode the next picture, blue first; all have the size of the first one, which is even."""
        if self._stream is None:
            self._stream = self._container.add_stream("libx264", rate=self._rate_hz)
            self._stream.height, self._stream.width = sheet.shape[:2]
            self._stream.pix_fmt = "yuv420p"
            self._stream.options = {"crf": "26", "preset": "ultrafast", "threads": "1"}
        planes = cv2.cvtColor(sheet, cv2.COLOR_BGR2YUV_I420)
        frame = av.VideoFrame.from_ndarray(np.asarray(planes, np.uint8), format="yuv420p")
        frame.pts, frame.time_base = self._frames, 1 / self._rate_hz
        self._frames += 1
        if self._whole:
            self._write(frame)

    def _write(self, frame: av.VideoFrame | None) -> None:
        """Encode a frame, or with None what is left of those before."""
        if self._stream is not None:
            self._whole = False
            self._container.mux(self._stream.encode(frame))
            self._whole = True

    def __enter__(self) -> "VideoStream":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        with self._file:
            if kind is None and self._whole:
                self._write(None)
            self._container.close()
