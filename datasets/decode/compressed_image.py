"""``sensor_msgs/CompressedImage``: JPEG and PNG as image_transport and camera drivers write them."""

from typing import Any

import cv2
import numpy as np
from jaxtyping import Shaped, UInt8

from navtool.base.errors import DatasetsError
from navtool.datasets.decode.encoded_size import refuse_giants
from navtool.datasets.decode.header import head_of
from navtool.datasets.decode.image import demosaiced, refuse_depth
from navtool.datasets.decode.messages import ImageFrame
from navtool.pipeline.arrays import Array

_JPEG = b"\xff\xd8\xff"
_PNG = b"\x89PNG\r\n\x1a\n"
_START_OF_SCAN = b"\xff\xda"
_END_OF_JPEG = b"\xff\xd9"
_END_OF_PNG = b"IEND"


def decode_compressed_image(message: Any) -> ImageFrame:
    """The image in RGB, in the orientation of the sensor.

    The bytes show JPEG or PNG. The format (``jpeg``, or image_transport's ``rgb8; jpeg compressed bgr8``) says what
    was compressed: a depth image, a Bayer mosaic, or red and blue exchanged.

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
    if encoding.startswith("bayer_"):
        return _frame(message, _bayer(data, encoding), compression)
    # image_transport gives OpenCV's encoder BGR. Where it notes that it gave RGB, the colours inside are exchanged.
    exchanged = "compressed rgb" in message.format
    return _frame(message, _decompressed(data, cv2.IMREAD_COLOR if exchanged else cv2.IMREAD_COLOR_RGB), compression)


def _frame(message: Any, rgb: UInt8[Array, "h w 3"], compression: str) -> ImageFrame:
    return ImageFrame(**head_of(message)._asdict(), rgb=rgb, encoding=compression)


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
