"""Packets of a video: FFMPEGPacket, foxglove.CompressedVideo, and H.264 or H.265 in a CompressedImage."""

import re
from typing import Any

from navtool.base.errors import DatasetsError
from navtool.datasets.decode.annex_b import head_of_packet, with_start_codes
from navtool.datasets.decode.header import head_of
from navtool.datasets.decode.messages import VideoPacket

_CODECS = (
    ("hevc", r"hevc|h\.?265|x265"),
    ("h264", r"h\.?264|x264|(?<![a-z])avc"),
    ("av1", r"av1|(?<![a-z])av01"),
    ("vp9", r"vp9|vp09"),
    ("vp8", r"vp8"),
    ("mpeg4", r"mpeg-?4"),
    ("mjpeg", r"mjpe?g"),
)
"""Codecs, as the decoder calls them, by what encoders are called; the first match wins."""
_KEY_FLAG = 1
_VOP, _INTRA = b"\0\0\1\xb6", 0
_SEQUENCE = 1


def codec_in(name: str) -> str | None:
    """The codec that a name such as ``h264``, ``hevc_nvenc`` or ``libx264`` means; None where it means no video."""
    return next((codec for codec, pattern in _CODECS if re.search(pattern, name.lower())), None)


def decode_ffmpeg_packet(message: Any) -> VideoPacket:
    """``ffmpeg_image_transport_msgs/FFMPEGPacket``: its encoding names codec or encoder, and behind it what it took.

    Raises:
        DatasetsError: The codec is unknown.
    """
    name = str(message.encoding).partition(";")[0]
    packet = video_packet(message, codec_in(name), name, message.data)
    return packet if packet.codec in ("h264", "hevc") else _keyed(packet, key=bool(int(message.flags) & _KEY_FLAG))


def video_packet(message: Any, codec: str | None, name: str, data: Any) -> VideoPacket:
    """A packet of a video whose message has a header.

    Raises:
        DatasetsError: The codec is unknown, or the packet is empty.
    """
    if codec is None:
        known = ", ".join(codec for codec, _ in _CODECS)
        raise DatasetsError(f"a video stream of {name!r}, which is not decoded; {known} are", cure="record images")
    if not len(data):
        raise DatasetsError("an empty packet of a video stream")
    head = head_of(message)._asdict()
    content = bytes(data)
    if codec not in ("h264", "hevc"):
        return VideoPacket(**head, codec=codec, data=content, key=_is_key(codec, content))
    content = with_start_codes(content)
    found = head_of_packet(content, h265=codec == "hevc")
    return VideoPacket(
        **head,
        codec=codec,
        data=content,
        key=found.key,
        parameters=found.parameters,
        sps=found.sps,
        slice_head=found.slice_[:64],
    )


def _keyed(packet: VideoPacket, *, key: bool) -> VideoPacket:
    return VideoPacket(**{**vars(packet), "key": key or packet.codec == "mjpeg"})


def _is_key(codec: str, data: bytes) -> bool:
    """Whether a packet of a codec without units begins a picture by itself."""
    match codec:
        case "vp8":
            return not data[0] & 1
        case "vp9":
            return data[0] >> 6 == 2 and not data[0] & 0b1100
        case "av1":
            # Behind the delimiter of two bytes the sequence's header.
            return _SEQUENCE in {(data[at] >> 3) & 0xF for at in (0, 2) if at < len(data)}
        case "mpeg4":
            place = data.find(_VOP)
            return place != -1 and place + 4 < len(data) and data[place + 4] >> 6 == _INTRA
        case _:
            return True
