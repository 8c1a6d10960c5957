"""Pictures out of a video's packets, each with the stamp of its own packet."""

from collections.abc import Iterator
from typing import Any, NamedTuple

import av
import av.error
import numpy as np

from navtool.datasets.decode.annex_b import head_of_packet
from navtool.datasets.decode.h264_order import H264Order
from navtool.datasets.decode.messages import ImageFrame, VideoPacket

_MOST_PENDING = 64
"""Packets whose pictures may be outstanding: a stream that reorders more is none that a robot records."""


class Shown(NamedTuple):
    """A picture, and the number of its packet."""

    number: int
    frame: ImageFrame


class VideoDecoder:
    """Decodes one stream of packets in the order of record, beginning with a key frame.

    Pictures come out in the order in which they are to be shown, behind the packets that they need. Behind packets that
    were lost or are damaged, there are none until the next key frame: what decoders make up is not what was seen.
    Memory is that of the codec's own pictures. One thread: the same packets give the same pictures.
    """

    def __init__(self) -> None:
        self._codec: Any = None
        self._name = ""
        self._order = H264Order()
        self._waits_for_key = True
        self._pending: dict[int, VideoPacket] = {}

    def feed(self, packet: VideoPacket, number: int, parameters: bytes = b"") -> list[Shown]:
        """The pictures that are ready with a packet.

        Args:
            number: Of the packet, by which its picture is known.
            parameters: Parameter sets to begin with, where the packet itself has none.
        """
        shown: list[Shown] = []
        if packet.codec != self._name:
            shown = self.flush()
            self._begin(packet.codec)
        in_order = packet.codec != "h264" or self._order.follows(
            packet.sps or head_of_packet(parameters, h265=False).sps, packet.slice_head
        )
        if packet.key:
            self._waits_for_key = False
        elif not in_order:
            self._waits_for_key = True
        if self._waits_for_key:
            return shown
        content = packet.data if packet.parameters or not parameters else parameters + packet.data
        unit = av.Packet(content)
        unit.pts = unit.dts = number
        self._pending[number] = packet
        if len(self._pending) > _MOST_PENDING:
            self._pending.pop(next(iter(self._pending)))
        return [*shown, *self._decoded(unit)]

    def flush(self) -> list[Shown]:
        """The pictures that are left when no packet follows; the decoder then begins anew."""
        shown = list(self._decoded(None)) if self._codec is not None else []
        self._codec, self._name = None, ""
        self._pending.clear()
        self._waits_for_key = True
        return shown

    def _begin(self, codec: str) -> None:
        self._codec = av.CodecContext.create(codec, "r")
        self._codec.thread_count = 1
        # Strict: streams that do not say how far they reorder pictures are taken to do it as far as they may.
        self._codec.options = {"strict": "strict"}
        self._name, self._order = codec, H264Order()

    def _decoded(self, unit: Any) -> Iterator[Shown]:
        try:
            frames = self._codec.decode(unit)
        except (av.error.FFmpegError, ValueError):
            self._waits_for_key = True
            return
        for frame in frames:
            packet = self._pending.pop(frame.pts, None)
            if packet is None or frame.is_corrupt:
                continue
            rgb = np.asarray(frame.to_ndarray(format="rgb24"), np.uint8)
            yield Shown(
                frame.pts,
                ImageFrame(stamp_ns=packet.stamp_ns, frame_id=packet.frame_id, rgb=rgb, encoding=packet.codec),
            )
