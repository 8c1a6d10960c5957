"""``sensor_msgs/Image``: raw pixels in the encodings that colour and grey cameras use."""

from collections.abc import Callable
from typing import Any, NamedTuple

import cv2
import numpy as np
from jaxtyping import Shaped, UInt8

from navtool.base.errors import DatasetsError
from navtool.datasets.decode.encoded_size import refuse_giants
from navtool.datasets.decode.header import head_of
from navtool.datasets.decode.messages import ImageFrame
from navtool.pipeline.arrays import Array

type Pixels = UInt8[Array, "h w *channels"]
type Rgb = UInt8[Array, "h w 3"]


class _Layout(NamedTuple):
    """Samples a pixel, bytes a sample, and the way to RGB once there are 8 bits a sample."""

    channels: int
    sample_bytes: int
    to_rgb: Callable[[Pixels], Rgb]


def _converted(code: int) -> Callable[[Pixels], Rgb]:
    def convert(pixels: Pixels) -> Rgb:
        return np.asarray(cv2.cvtColor(pixels, code), np.uint8)

    return convert


def _as_it_is(pixels: Pixels) -> Rgb:
    return pixels


_GREY = _converted(cv2.COLOR_GRAY2RGB)
# ROS names a mosaic by the pixels of its first two rows; so do these names of OpenCV, unlike its older ones.
_BAYER = {
    "bayer_rggb": _converted(cv2.COLOR_BayerRGGB2RGB),
    "bayer_bggr": _converted(cv2.COLOR_BayerBGGR2RGB),
    "bayer_gbrg": _converted(cv2.COLOR_BayerGBRG2RGB),
    "bayer_grbg": _converted(cv2.COLOR_BayerGRBG2RGB),
}
_LAYOUTS: dict[str, _Layout] = {
    "rgb8": _Layout(3, 1, _as_it_is),
    "bgr8": _Layout(3, 1, _converted(cv2.COLOR_BGR2RGB)),
    "rgba8": _Layout(4, 1, _converted(cv2.COLOR_RGBA2RGB)),
    "bgra8": _Layout(4, 1, _converted(cv2.COLOR_BGRA2RGB)),
    "mono8": _Layout(1, 1, _GREY),
    "8UC1": _Layout(1, 1, _GREY),
    "mono16": _Layout(1, 2, _GREY),
    **{f"{name}8": _Layout(1, 1, to_rgb) for name, to_rgb in _BAYER.items()},
    **{f"{name}16": _Layout(1, 2, to_rgb) for name, to_rgb in _BAYER.items()},
    "yuv422": _Layout(2, 1, _converted(cv2.COLOR_YUV2RGB_UYVY)),
    "uyvy": _Layout(2, 1, _converted(cv2.COLOR_YUV2RGB_UYVY)),
    "yuv422_yuy2": _Layout(2, 1, _converted(cv2.COLOR_YUV2RGB_YUY2)),
    "yuyv": _Layout(2, 1, _converted(cv2.COLOR_YUV2RGB_YUY2)),
}
_DEPTH = ("16UC1", "32FC1", "16SC1", "64FC1")


def decode_image(message: Any) -> ImageFrame:
    """The image in RGB; 16-bit samples keep their upper byte, that is, full scale stays full scale.

    An ``rgb8`` image costs nothing: it is a read-only view of the message.

    Raises:
        DatasetsError: A depth image, an unknown encoding, no pixels, or fewer bytes than its size says.
    """
    encoding = message.encoding
    refuse_depth(encoding)
    if _is_jpeg(message):
        return _frame_of_jpeg(message)
    layout = _LAYOUTS.get(encoding)
    if layout is None:
        raise DatasetsError(f"image encoding {encoding!r} is not supported; {', '.join(_LAYOUTS)} are")
    samples = _samples(message, layout)
    if layout.sample_bytes == 2:
        samples = (samples >> 8).astype(np.uint8)
    return ImageFrame(**head_of(message)._asdict(), rgb=layout.to_rgb(samples), encoding=encoding)


def _is_jpeg(message: Any) -> bool:
    """Whether the pixels are a JPEG, as a Spot driver publishes them under the name of rgb8."""
    data = message.data
    short = data.nbytes < int(message.width) * int(message.height)
    return bool(short and data.nbytes > 3 and bytes(data[:3]) == b"\xff\xd8\xff")


def _frame_of_jpeg(message: Any) -> ImageFrame:
    refuse_giants(bytes(message.data))
    pixels = cv2.imdecode(np.asarray(message.data, np.uint8), cv2.IMREAD_COLOR_RGB | cv2.IMREAD_IGNORE_ORIENTATION)
    if pixels is None:
        raise DatasetsError(f"damaged image of {message.data.nbytes} bytes: it cannot be decompressed")
    return ImageFrame(**head_of(message)._asdict(), rgb=np.asarray(pixels, np.uint8), encoding="jpeg")


def refuse_depth(encoding: str) -> None:
    """Do nothing, but for the encodings of depth images.

    Raises:
        DatasetsError: It is one of them.
    """
    if encoding in _DEPTH:
        raise DatasetsError(
            f"encoding {encoding!r} is a depth image, which navtool does not use",
            cure="map the topic of the colour or grey camera",
        )


def demosaiced(mosaic: UInt8[Array, "h w"], encoding: str) -> Rgb:
    """The RGB image of a Bayer mosaic; the encoding is one of ``bayer_*8``.

    Raises:
        DatasetsError: It is another.
    """
    to_rgb = _BAYER.get(encoding.removesuffix("8"))
    if to_rgb is None:
        raise DatasetsError(f"encoding {encoding!r} is no 8-bit Bayer mosaic; {', '.join(x + '8' for x in _BAYER)} are")
    return to_rgb(mosaic)


def _samples(message: Any, layout: _Layout) -> Shaped[Array, "h w *channels"]:
    """The samples as an (h, w) or (h, w, channels) view of the message, without the padding of its rows."""
    width, height, step = int(message.width), int(message.height), int(message.step)
    row_bytes = width * layout.channels * layout.sample_bytes
    if width == 0 or height == 0:
        raise DatasetsError(f"an image of {width} x {height} pixels")
    if step < row_bytes:
        raise DatasetsError(f"step is {step} bytes, but a row of {width} {message.encoding} pixels takes {row_bytes}")
    # The padding behind the last row may be left out.
    needed = step * (height - 1) + row_bytes
    if message.data.nbytes < needed:
        raise DatasetsError(f"truncated image: {message.data.nbytes} bytes of pixels, but its size needs {needed}")
    dtype = np.dtype(np.uint8 if layout.sample_bytes == 1 else (">u2" if message.is_bigendian else "<u2"))
    pixel = (layout.channels,) if layout.channels > 1 else ()
    strides = (step, layout.channels * layout.sample_bytes, *((layout.sample_bytes,) if pixel else ()))
    return np.ndarray((height, width, *pixel), dtype, buffer=message.data, strides=strides)
