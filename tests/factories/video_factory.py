"""Packets of videos by the codecs' own encoders."""

from collections.abc import Callable
from fractions import Fraction
from typing import Any, NamedTuple

import av
from field_drives import HEIGHT, WIDTH, picture

FFMPEG = "ffmpeg_image_transport_msgs/msg/FFMPEGPacket"
_FIELDS = (
    "std_msgs/Header header\nint32 width\nint32 height\nstring encoding\nuint64 pts\nuint8 flags\n"
    "bool is_bigendian\nuint8[] data"
)
FFMPEG_TYPES = ((FFMPEG, _FIELDS),)


class Encoded(NamedTuple):
    """A packet, in the order of decoding."""

    number: int
    """Of the picture that it is of, counted in the order of time."""
    data: bytes
    key: bool


def encoded(encoder: str, count: int, make: Callable[[int], Any] = picture, **options: object) -> list[Encoded]:
    """The packets of so many pictures at 10 Hz."""
    codec: Any = av.CodecContext.create(encoder, "w")
    codec.width, codec.height, codec.pix_fmt = WIDTH, HEIGHT, "yuv420p"
    codec.time_base, codec.framerate = Fraction(1, 10), Fraction(10)
    codec.options = {name.replace("_", "-"): str(value) for name, value in options.items()}
    packets = []
    for number in range(count):
        frame = av.VideoFrame.from_ndarray(make(number), format="rgb24")
        frame.pts = number
        packets += codec.encode(frame)
    packets += codec.encode(None)
    return [Encoded(int(packet.pts), bytes(packet), bool(packet.is_keyframe)) for packet in packets]
