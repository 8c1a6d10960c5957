"""What the first pass keeps of a camera whose pictures are a video: where decoding can begin."""

from bisect import bisect_right
from dataclasses import dataclass, field

from navtool.datasets.decode.messages import ImageFrame, VideoPacket
from navtool.datasets.decode.video_decoder import VideoDecoder

_MOST_TRIED = 128
"""Packets from the first key frame on that are decoded in search of a picture."""


@dataclass(slots=True)
class VideoSurvey:
    """Key frames by their positions in the order of record, with the parameter sets to begin with."""

    codecs: dict[str, None] = field(default_factory=dict)
    keys: list[int] = field(default_factory=list)
    parameters: dict[int, bytes] = field(default_factory=dict)
    """The last ones before a key frame, for those whose own packet has none."""
    packets: int = 0
    _last_parameters: bytes = b""
    _tried: int = 0
    _decoder: VideoDecoder | None = field(default_factory=VideoDecoder)

    @property
    def before_first_key(self) -> int:
        """Positions before the first key frame."""
        return self.keys[0] if self.keys else self.packets

    def add(self, packet: VideoPacket, position: int) -> ImageFrame | None:
        """Note a packet; the first picture of the video, once there is one."""
        self.codecs[packet.codec] = None
        self.packets = position + 1
        self._last_parameters = packet.parameters or self._last_parameters
        if packet.key:
            self.keys.append(position)
            if not packet.parameters and self._last_parameters:
                self.parameters[position] = self._last_parameters
        if self._decoder is None or not self.keys or self._tried >= _MOST_TRIED:
            return None
        self._tried += 1
        shown = self._decoder.feed(packet, position, self.parameters.get(position, b""))
        return self._first(shown[0].frame if shown else None)

    def finish(self) -> ImageFrame | None:
        """The first picture where it only comes once no packet follows."""
        shown = self._decoder.flush() if self._decoder is not None else []
        return self._first(shown[0].frame if shown else None)

    def start_for(self, position: int) -> int:
        """Where decoding begins for the picture of a packet: at the key frame before the last one.

        Pictures shown before a key frame may need those before it.
        """
        place = bisect_right(self.keys, position) - 1
        return self.keys[max(place - 1, 0)] if self.keys else position

    def without_decoder(self) -> "VideoSurvey":
        """The same to be sent to another process."""
        return VideoSurvey(self.codecs, self.keys, self.parameters, self.packets, self._last_parameters, 0, None)

    def _first(self, frame: ImageFrame | None) -> ImageFrame | None:
        if frame is not None:
            self._decoder = None
        return frame
