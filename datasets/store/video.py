"""Writing camera frames as a video that is quick to seek in."""

from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path
from types import TracebackType

import av
import cv2
import numpy as np
from jaxtyping import UInt8

from navtool.datasets.store.reading import reading
from navtool.datasets.store.schema import IMAGE_HEIGHT_PX, IMAGE_WIDTH_PX
from navtool.pipeline.arrays import Array

KEYFRAME_EVERY = 2
"""A key frame every second frame: reading any frame decodes at most two."""


class VideoWriter:
    """Encodes RGB frames of 240x320 as H.264 (CRF 23), one frame a tick, in the order in which they are given.

    The same frames give the same bytes on the same build of the codec. Use it as a context manager; leaving it
    without an error finishes the file.
    """

    def __init__(self, path: Path, fps: int) -> None:
        path.parent.mkdir(parents=True, exist_ok=True)
        self._container = av.open(str(path), "w", format="mp4")
        stream = self._container.add_stream("libx264", rate=Fraction(fps))
        stream.width, stream.height, stream.pix_fmt = IMAGE_WIDTH_PX, IMAGE_HEIGHT_PX, "yuv420p"
        stream.options = {
            "crf": "23",
            "g": str(KEYFRAME_EVERY),
            "bf": "0",
            "preset": "ultrafast",
            "threads": "1",
        }
        self._stream = stream
        self._time_base = Fraction(1, fps)
        self._frames = 0

    def add(self, rgb: UInt8[Array, "240 320 3"]) -> None:
        """Encode the next frame."""
        # OpenCV turns RGB into the encoder's planes faster than the encoder's own scaler.
        planes = cv2.cvtColor(np.ascontiguousarray(rgb), cv2.COLOR_RGB2YUV_I420)
        frame = av.VideoFrame.from_ndarray(np.asarray(planes, np.uint8), format="yuv420p")
        frame.pts = self._frames
        frame.time_base = self._time_base
        self._frames += 1
        for packet in self._stream.encode(frame):
            self._container.mux(packet)

    def __enter__(self) -> "VideoWriter":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if kind is None:
            for packet in self._stream.encode(None):
                self._container.mux(packet)
        self._container.close()


def join_videos(parts: Sequence[Path], out: Path, fps: int) -> list[int]:
    """One video out of several of `VideoWriter`'s, packet by packet, without encoding anything again.

    Returns:
        How many frames came of each part.

    Raises:
        DatasetsError: A part is damaged or not there.
    """
    frames: list[int] = []
    out.parent.mkdir(parents=True, exist_ok=True)
    with av.open(str(out), "w", format="mp4", options={"movflags": "faststart"}) as joined:
        target: av.VideoStream | None = None
        frame = 0
        for part in parts:
            before = frame
            with reading(part), av.open(str(part)) as source:
                video = source.streams.video[0]
                if target is None:
                    target = joined.add_stream_from_template(video)
                    target.time_base = Fraction(1, fps)
                for packet in source.demux(video):
                    if packet.size == 0:
                        continue  # the end of the part
                    packet.stream, packet.time_base = target, Fraction(1, fps)
                    packet.pts = packet.dts = frame
                    packet.duration = 1
                    joined.mux(packet)
                    frame += 1
            frames.append(frame - before)
    return frames
