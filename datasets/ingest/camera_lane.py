"""Camera frames on their way into a segment's rows."""

from dataclasses import replace

import cv2
import numpy as np
from jaxtyping import UInt8

from navtool.base.errors import DatasetsError
from navtool.base.note import Note
from navtool.datasets.decode.messages import Decoded, ImageFrame, VideoPacket
from navtool.datasets.decode.video_decoder import Shown, VideoDecoder
from navtool.datasets.ingest.lane import Lane, logger
from navtool.datasets.ingest.segment import Segment, VideoPart
from navtool.datasets.recording import RawMessage, Recording
from navtool.datasets.store.schema import IMAGE_HEIGHT_PX, IMAGE_WIDTH_PX, camera_reliability_keys
from navtool.datasets.store.stats import ImageStats
from navtool.datasets.store.video import VideoWriter
from navtool.pipeline.arrays import Array
from navtool.pipeline.image_reliability import ImageReliabilityConfig, image_reliability

type Image = UInt8[Array, "240 320 3"]

_BLACK: Image = np.zeros((IMAGE_HEIGHT_PX, IMAGE_WIDTH_PX, 3), dtype=np.uint8)


class CameraLane(Lane):
    """Judges frames as they were recorded, makes them small and encodes them.

    A row without a frame shows the last one before it, those before the first frame that one; all are black where none
    is near.

    Almost all of its time is spent outside of the interpreter, so that it runs beside a lane that needs it.
    """

    def __init__(self, stream: str, segment: Segment, video: VideoWriter, reliability: ImageReliabilityConfig) -> None:
        super().__init__(stream, segment.parts.get(stream), segment.ticks, camera_reliability_keys(stream))
        self.stats = ImageStats()
        self._video, self._reliability = video, reliability
        self._frames: dict[int, Image] = {}
        self._last: Image | None = None
        self._before_first = 0
        """Rows that wait for the first frame."""
        self._decoder = VideoDecoder()
        self._missing: set[int] = set()
        """Packets of this segment's own whose picture has not come."""

    def take(self, recording: Recording, raw: RawMessage, position: int) -> None:
        """Use the message at a position of the stream's order of record; of a video, the pictures that come with it."""
        if self._part.video is None:
            super().take(recording, raw, position)
        elif self._part.video.first <= position <= self._part.video.last:
            self._take_packet(self._part.video, recording, raw, position)

    def finish(self) -> None:
        """Write what is left; ticks whose message never came are without it."""
        self._use_pictures(self._decoder.flush())
        if self._part.video is not None:
            # Packets before the first key frame stand in the plan's count.
            self.undecodable += sum(self._part.video.first <= position for position in self._missing)
        super().finish()
        for _ in range(self._before_first):
            self._video.add(_BLACK if self._last is None else self._last)

    def _wanted(self, position: int) -> bool:
        """Whether it is a frame that stands in for those of this segment's first ticks."""
        return position in self._part.segment_ticks

    def _take_packet(self, video: VideoPart, recording: Recording, raw: RawMessage, position: int) -> None:
        self._missing |= {position} & self._part.own
        try:
            packet = recording.decode(raw)
        except DatasetsError as error:
            logger.debug("%s: %s", raw.topic, error)
            return
        if not isinstance(packet, VideoPacket):
            return
        self._use_pictures(self._decoder.feed(packet, position, video.parameters.get(position, b"")))

    def _use_pictures(self, shown: list[Shown]) -> None:
        for number, frame in shown:
            self._missing.discard(number)
            ticks = self._part.segment_ticks.get(number)
            if ticks is not None:
                seen = self._seen(frame)
                if ticks:
                    self._add_odd(seen)
                self._use(seen, ticks)
                self._waits[ticks] = False
        self._settle()

    def _seen(self, sample: Decoded) -> Decoded:
        return (
            reshaped(self._part.view.shown(sample), self._part.native_size)
            if isinstance(sample, ImageFrame)
            else sample
        )

    def _use(self, sample: Decoded, ticks: list[int], raw: RawMessage | None = None, position: int = 0) -> None:  # noqa: ARG002
        if not isinstance(sample, ImageFrame):
            raise TypeError(f"{type(sample).__name__} is no frame")
        shrinks = sample.rgb.shape[1] > IMAGE_WIDTH_PX
        how = cv2.INTER_AREA if shrinks else cv2.INTER_LINEAR
        small = cv2.resize(sample.rgb, (IMAGE_WIDTH_PX, IMAGE_HEIGHT_PX), interpolation=how)
        frame = small.astype(np.uint8, copy=False)
        if ticks:
            self._set_reliability(ticks, image_reliability(sample.rgb, self._reliability))
        elif self._last is None:
            self._last = frame
        for tick in ticks:
            self._frames[tick] = frame

    def _write(self, tick: int) -> None:
        frame = self._frames.pop(tick, None)
        if frame is not None:
            self._last = frame
            self.stats.add(frame)
        if self._last is None:
            self._before_first += 1
            return
        for _ in range(self._before_first + 1):
            self._video.add(self._last)
        self._before_first = 0


def reshaped(frame: ImageFrame, first: tuple[int, int] | None) -> ImageFrame:
    """The picture, with a note where its shape is another one than the first picture's."""
    height, width = frame.rgb.shape[:2]
    if first is None or abs(width * first[1] - height * first[0]) <= max(first):
        return frame
    what = f"pictures of {width}x{height} among those of {first[0]}x{first[1]}: stretched to the rows' size"
    return replace(frame, notes=(*frame.notes, Note("image.other-shape", f"{what}; the calibration is not theirs")))
