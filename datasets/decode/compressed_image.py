"""``sensor_msgs/CompressedImage``: JPEG and PNG as image_transport and camera drivers write them."""

from collections.abc import Callable
from typing import Any

import cv2
import numpy as np
from jaxtyping import Shaped, UInt8

from navtool.base.errors import DatasetsError
from navtool.base.note import Note
from navtool.datasets.decode.encoded_size import refuse_giants
from navtool.datasets.decode.header import head_of
from navtool.datasets.decode.image import demosaiced, refuse_depth
from navtool.datasets.decode.levels import FULL, Deep
from navtool.datasets.decode.messages import ImageFrame, VideoPacket
from navtool.datasets.decode.video_packet import codec_in, video_packet
from navtool.pipeline.arrays import Array

_JPEG = b"\xff\xd8\xff"
_PNG = b"\x89PNG\r\n\x1a\n"
_START_CODES = (b"\0\0\0\1", b"\0\0\1")
"""H.264, as drivers without a name for it put it into such messages."""
_START_OF_SCAN = b"\xff\xda"
_END_OF_JPEG = b"\xff\xd9"
_END_OF_PNG = b"IEND"
_PNG_DEPTH = 24
"""Where a PNG says how many bits its samples have."""


def decode_compressed_image(message: Any) -> ImageFrame | VideoPacket:
    """A JPEG or PNG image as `decode_still` has it, or a packet of a video where the bytes are none of both.

    Raises:
        DatasetsError: A depth image, another compression, or damaged data.
    """
    codec = codec_in(message.format)
    start = bytes(message.data[:8])
    if not start.startswith((_JPEG, _PNG)) and (codec or start.startswith(_START_CODES)):
        return video_packet(message, codec or "h264", message.format, message.data)
    return decode_still(message)


def decode_still(message: Any) -> ImageFrame:
    """The image in RGB, in the orientation of the sensor.

    The bytes show JPEG or PNG. The format (``jpeg``, or image_transport's ``rgb8; jpeg compressed bgr8``) says what
    was compressed: a depth image, a Bayer mosaic, or red and blue exchanged. Colours are those of the file, but where
    the format says that RGB was given to an encoder that takes BGR; that is put right, and noted.

    Raises:
        DatasetsError: A depth image, another compression, or damaged data.
    """
    encoding = message.format.partition(";")[0].strip()
    refuse_depth(encoding)
    if "compressedDepth" in message.format:
        raise DatasetsError(
            f"format {message.format!r} is a depth image, which navtool does not use",
            cure="map the topic of the colour or grey camera",
        )
    data = message.data.tobytes()
    compression = _compression(data, message.format)
    head = head_of(message)._asdict()
    notes = _label_notes(message.format, compression)
    if compression == "png" and data[_PNG_DEPTH : _PNG_DEPTH + 1] == b"\x10":
        deep = Deep(*_of_16_bits(data, encoding))
        return ImageFrame(**head, rgb=deep.rgb(FULL), encoding=compression, notes=notes, deep=deep)
    if encoding.startswith("bayer_"):
        return ImageFrame(**head, rgb=_bayer(data, encoding), encoding=compression, notes=notes)
    exchanged = _exchanged(message.format)
    if exchanged:
        what = f"by the format {message.format!r} the files hold red and blue exchanged; they are put right"
        cure = "pictures: {front: {colours: as_held}} in the robot file takes them as they are"
        notes = (*notes, Note("image.colours-exchanged", f"{what}; {cure}"))
    rgb = _decompressed(data, cv2.IMREAD_COLOR if exchanged else cv2.IMREAD_COLOR_RGB)
    return ImageFrame(**head, rgb=rgb, encoding=compression, notes=notes, exchanged=exchanged)


def _exchanged(form: str) -> bool:
    """Whether RGB was given to OpenCV's encoder, which takes BGR: what ROS's writers mean by ``compressed rgb8``."""
    return form.partition("compressed ")[2].strip().startswith("rgb")


def _label_notes(form: str, compression: str) -> tuple[Note, ...]:
    """A note where the format names the other compression."""
    other = "png" if compression == "jpeg" else "jpeg"
    words = form.lower().replace("jpg", "jpeg")
    if other not in words or compression in words:
        return ()
    return (
        Note("image.label", f"the format says {form!r}, the bytes are {compression.upper()}: they are read as that"),
    )


def _of_16_bits(data: bytes, encoding: str) -> tuple[Any, Callable[[Any], Any]]:
    """The samples of a PNG of 16 bits, and the way to colours once there are 8."""
    samples = _decompressed(data, cv2.IMREAD_UNCHANGED)
    if samples.ndim == 2:
        if encoding.startswith("bayer_"):
            return samples, lambda mosaic: demosaiced(mosaic, encoding.replace("16", "8"))
        return samples, lambda grey: cv2.cvtColor(grey, cv2.COLOR_GRAY2RGB)
    return samples, lambda pixels: cv2.cvtColor(np.ascontiguousarray(pixels[..., :3]), cv2.COLOR_BGR2RGB)


def _compression(data: bytes, form: str) -> str:
    if data.startswith(_JPEG):
        # Decoders fill what is missing with grey; the marker can only stand behind the pixels. No pixels may follow the
        # last one: asked in this order, a whole image is looked at from its end alone.
        if data.find(_START_OF_SCAN, max(data.rfind(_END_OF_JPEG), 0)) != -1:
            raise DatasetsError(f"truncated JPEG image of {len(data)} bytes")
        return "jpeg"
    if data.startswith(_PNG):
        if _END_OF_PNG not in data[-64:]:
            raise DatasetsError(f"truncated PNG image of {len(data)} bytes")
        return "png"
    raise DatasetsError(f"compressed data that is neither JPEG nor PNG; the message calls it {form!r}")


def _bayer(data: bytes, encoding: str) -> UInt8[Array, "h w 3"]:
    pixels = _decompressed(data, cv2.IMREAD_UNCHANGED)
    if pixels.ndim == 2:
        return demosaiced(pixels, encoding)
    return np.asarray(cv2.cvtColor(pixels, cv2.COLOR_BGR2RGB), np.uint8)


def _decompressed(data: bytes, mode: int) -> Shaped[Array, "h w *channels"]:
    # The orientation noted in EXIF is for viewers; the calibration is for the sensor's rows and columns.
    refuse_giants(data)
    flags = mode if mode == cv2.IMREAD_UNCHANGED else mode | cv2.IMREAD_IGNORE_ORIENTATION
    pixels = cv2.imdecode(np.frombuffer(data, np.uint8), flags)
    if pixels is None:
        raise DatasetsError(f"damaged image of {len(data)} bytes: it cannot be decompressed")
    return np.asarray(pixels)
