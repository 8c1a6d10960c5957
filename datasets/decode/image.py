"""``sensor_msgs/Image``: raw pixels in the encodings that colour and grey cameras use."""

from collections.abc import Callable
from typing import Any, NamedTuple

import cv2
import numpy as np
from jaxtyping import Shaped, UInt8

from navtool.base.errors import DatasetsError
from navtool.base.note import Note
from navtool.datasets.decode.encoded_size import refuse_giants
from navtool.datasets.decode.header import head_of
from navtool.datasets.decode.image_rows import MISFIT, Rows, rows_of, step_that_fills
from navtool.datasets.decode.levels import FULL, Deep
from navtool.datasets.decode.messages import ImageFrame
from navtool.pipeline.arrays import Array

type Pixels = UInt8[Array, "rows w *channels"]
"""Rows of all planes where there are several; else those of the image."""
type Rgb = UInt8[Array, "h w 3"]


class _Layout(NamedTuple):
    """Samples a pixel, bytes a sample, and the way to RGB once there are 8 bits a sample."""

    channels: int
    sample_bytes: int
    to_rgb: Callable[[Pixels], Rgb]
    planes: float = 1.0
    """Rows of all planes together, of one byte a pixel, for each row of the image."""
    shared: tuple[int, int] = (1, 1)
    """Columns and rows that share their chroma: the size is a multiple of them."""


def _converted(code: int) -> Callable[[Pixels], Rgb]:
    def convert(pixels: Pixels) -> Rgb:
        return np.asarray(cv2.cvtColor(pixels, code), np.uint8)

    return convert


def _as_it_is(pixels: Pixels) -> Rgb:
    return pixels


def _of_two_planes(pixels: Pixels) -> Rgb:
    """Luma, then chroma for two columns (NV16): one pixel's luma beside either chroma, as YUYV has them."""
    luma, chroma = np.split(pixels, 2)
    return _converted(cv2.COLOR_YUV2RGB_YUY2)(np.stack([luma, chroma], axis=-1))


def _of_full_chroma(pixels: Pixels) -> Rgb:
    """Luma, then chroma of its own for every pixel (NV24), of which every second one is taken, as NV12 has them."""
    height, width = pixels.shape[0] // 3, pixels.shape[1]
    chroma = pixels[height:].reshape(height, width, 2)[::2, ::2].reshape(-1, width)
    return _converted(cv2.COLOR_YUV2RGB_NV12)(np.concatenate([pixels[:height], chroma]))


def _reordered(order: tuple[int, ...]) -> Callable[[Pixels], Rgb]:
    def reorder(pixels: Pixels) -> Rgb:
        return np.ascontiguousarray(pixels[..., order])

    return reorder


_GREY = _converted(cv2.COLOR_GRAY2RGB)
_BGR = _reordered((2, 1, 0))
# ROS names a mosaic by the pixels of its first two rows; so do these names of OpenCV, unlike its older ones.
_BAYER = {
    "bayer_rggb": _converted(cv2.COLOR_BayerRGGB2RGB),
    "bayer_bggr": _converted(cv2.COLOR_BayerBGGR2RGB),
    "bayer_gbrg": _converted(cv2.COLOR_BayerGBRG2RGB),
    "bayer_grbg": _converted(cv2.COLOR_BayerGRBG2RGB),
}
_UYVY, _YUYV = _converted(cv2.COLOR_YUV2RGB_UYVY), _converted(cv2.COLOR_YUV2RGB_YUY2)
_LAYOUTS: dict[str, _Layout] = {
    "rgb8": _Layout(3, 1, _as_it_is),
    "bgr8": _Layout(3, 1, _converted(cv2.COLOR_BGR2RGB)),
    "rgba8": _Layout(4, 1, _converted(cv2.COLOR_RGBA2RGB)),
    "bgra8": _Layout(4, 1, _converted(cv2.COLOR_BGRA2RGB)),
    "mono8": _Layout(1, 1, _GREY),
    "8UC1": _Layout(1, 1, _GREY),
    # Channels without names are in OpenCV's order.
    "8UC3": _Layout(3, 1, _converted(cv2.COLOR_BGR2RGB)),
    "8UC4": _Layout(4, 1, _converted(cv2.COLOR_BGRA2RGB)),
    "mono16": _Layout(1, 2, _GREY),
    "rgb16": _Layout(3, 2, _as_it_is),
    "bgr16": _Layout(3, 2, _BGR),
    "rgba16": _Layout(4, 2, _reordered((0, 1, 2))),
    "bgra16": _Layout(4, 2, _BGR),
    "16UC3": _Layout(3, 2, _BGR),
    "16UC4": _Layout(4, 2, _BGR),
    **{f"{name}8": _Layout(1, 1, to_rgb) for name, to_rgb in _BAYER.items()},
    **{f"{name}16": _Layout(1, 2, to_rgb) for name, to_rgb in _BAYER.items()},
    "yuv422": _Layout(2, 1, _UYVY, shared=(2, 1)),
    "uyvy": _Layout(2, 1, _UYVY, shared=(2, 1)),
    "yuv422_uyvy": _Layout(2, 1, _UYVY, shared=(2, 1)),
    "yuv422_yuy2": _Layout(2, 1, _YUYV, shared=(2, 1)),
    "yuyv": _Layout(2, 1, _YUYV, shared=(2, 1)),
    "yuy2": _Layout(2, 1, _YUYV, shared=(2, 1)),
    "yvyu": _Layout(2, 1, _converted(cv2.COLOR_YUV2RGB_YVYU), shared=(2, 1)),
    "nv12": _Layout(1, 1, _converted(cv2.COLOR_YUV2RGB_NV12), 1.5, (2, 2)),
    "nv21": _Layout(1, 1, _converted(cv2.COLOR_YUV2RGB_NV21), 1.5, (2, 2)),
    "i420": _Layout(1, 1, _converted(cv2.COLOR_YUV2RGB_I420), 1.5, (2, 2)),
    "yuv420": _Layout(1, 1, _converted(cv2.COLOR_YUV2RGB_I420), 1.5, (2, 2)),
    "yv12": _Layout(1, 1, _converted(cv2.COLOR_YUV2RGB_YV12), 1.5, (2, 2)),
    "nv16": _Layout(1, 1, _of_two_planes, 2.0, (2, 1)),
    "nv24": _Layout(1, 1, _of_full_chroma, 3.0),
}
_OTHER_NAMES = {
    "rgb": "rgb8",
    "bgr": "bgr8",
    "rgba": "rgba8",
    "bgra": "bgra8",
    "rgb888": "rgb8",
    "bgr888": "bgr8",
    "mono": "mono8",
    "gray": "mono8",
    "grey": "mono8",
    "gray8": "mono8",
    "y8": "mono8",
    "l8": "mono8",
    "y16": "mono16",
    "gray16": "mono16",
    "grey16": "mono16",
    "l16": "mono16",
    **{
        f"bayer{name}8": f"bayer_{pattern}8"
        for name, pattern in (("rg", "rggb"), ("bg", "bggr"), ("gb", "gbrg"), ("gr", "grbg"))
    },
}
"""Names outside of ROS's list that drivers write, in small letters."""
_ONE_STEP = ("nv12", "nv21", "nv16")
"""Encodings of several planes whose rows are all of one length."""
_ROWS_LOOKED_AT = 24
_ROUGHER = 4.0
_UNLIKE = 2.0
_UNUSED_BITS = 64
"""Of samples that use 14 bits or fewer one byte is below."""
_DEPTH = ("16UC1", "32FC1", "16SC1", "64FC1")


def decode_image(message: Any) -> ImageFrame:
    """The image in RGB; 16-bit samples keep their upper byte, that is, full scale stays full scale.

    Of 16-bit samples ``deep`` holds all bits: what range a camera uses of them, one picture does not say. An ``rgb8``
    image costs nothing: it is a read-only view of the message.

    Raises:
        DatasetsError: A depth image, an unknown encoding, no pixels, or fewer bytes than its size says.
    """
    encoding = message.encoding
    refuse_depth(encoding)
    if _is_jpeg(message):
        return _frame_of_jpeg(message)
    layout = _layout(encoding)
    samples, notes = _samples(message, layout)
    head = head_of(message)._asdict()
    if layout.sample_bytes == 1:
        return ImageFrame(**head, rgb=layout.to_rgb(samples), encoding=encoding, notes=notes)
    deep, turned = _deep(samples, layout)
    return ImageFrame(**head, rgb=deep.rgb(FULL), encoding=encoding, notes=(*notes, *turned), deep=deep)


def _layout(encoding: str) -> _Layout:
    name = _OTHER_NAMES.get(encoding.lower(), encoding)
    layout = _LAYOUTS.get(name) or _LAYOUTS.get(name.lower())
    if layout is None:
        raise DatasetsError(f"image encoding {encoding!r} is not supported; {', '.join(_LAYOUTS)} are")
    return layout


def _deep(samples: Shaped[Array, "h w *channels"], layout: _Layout) -> tuple[Deep, tuple[Note, ...]]:
    """Samples of 16 bits, in the order of bytes in which neighbours are alike."""
    turned = samples.view(samples.dtype.newbyteorder())
    noise = _roughness(turned) * _ROUGHER < _roughness(samples)
    if noise or _is_unused_below(samples):
        said = "big" if samples.dtype.byteorder == ">" else "little"
        why = "noise" if noise else "without their middle bits"
        what = f"samples are {why} as {said}-endian numbers and a picture the other way round: that is taken"
        return Deep(turned.astype(np.uint16), layout.to_rgb), (Note(MISFIT, what),)
    return Deep(samples.astype(np.uint16), layout.to_rgb), ()


def _is_unused_below(samples: Shaped[Array, "h w *channels"]) -> bool:
    """Whether the bits that are never used are those of the low byte, though samples differ in its other ones."""
    rows = samples[:: max(1, samples.shape[0] // _ROWS_LOOKED_AT)]
    low, high = rows & 0xFF, rows >> 8
    return bool(0 < low.max() < _UNUSED_BITS and int(high.max()) - int(high.min()) >= 2 * _UNUSED_BITS)


def _roughness(samples: Shaped[Array, "h w *channels"]) -> float:
    """How much neighbours differ, in shares of the whole range, in a few rows."""
    rows = samples[:: max(1, samples.shape[0] // _ROWS_LOOKED_AT)].astype(np.int32)
    span = int(rows.max()) - int(rows.min())
    # Second neighbours: in a mosaic they are of one colour.
    return float(np.abs(rows[:, 2:] - rows[:, :-2]).mean()) / span if span and rows.shape[1] > 2 else 0.0


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


def _samples(message: Any, layout: _Layout) -> tuple[Shaped[Array, "h w *channels"], tuple[Note, ...]]:
    """The samples as a view of the message without the padding of its rows, and what is odd about its size.

    Of several planes, (h, w) of them one below the other; else (h, w) or (h, w, channels).
    """
    pixel_bytes = layout.channels * layout.sample_bytes
    width, height, step = int(message.width), int(message.height), int(message.step)
    odd = [size for size, shared in zip((width, height), layout.shared, strict=True) if size % shared]
    if odd:
        raise DatasetsError(
            f"an image of {width} x {height} {message.encoding} pixels, of which two share their chroma"
        )
    rows = rows_of(width, height, step, message.data.nbytes, pixel_bytes, layout.planes, message.encoding)
    dtype = np.dtype(np.uint8 if layout.sample_bytes == 1 else (">u2" if message.is_bigendian else "<u2"))
    filling = step_that_fills(int(rows.height * layout.planes), rows.step, message.data.nbytes)
    if filling and _is_smoother(message.data, dtype, rows, filling, rows.width * pixel_bytes):
        what = "step leaves bytes that longer rows fill, and one is like the next only so: that is taken"
        rows = Rows(rows.width, rows.height, filling, (Note(MISFIT, what),))
    pixel = (layout.channels,) if layout.channels > 1 else ()
    strides = (rows.step, pixel_bytes, *((layout.sample_bytes,) if pixel else ()))
    if layout.planes > 1 and rows.step != rows.width and message.encoding.lower() not in _ONE_STEP:
        raise DatasetsError(f"{message.encoding} with padded rows: how its planes are padded is not known")
    shape = (int((rows.luma_rows or rows.height) * layout.planes), rows.width, *pixel)
    # The padding behind the last row may be left out.
    samples: Array = np.ndarray(shape, dtype, buffer=message.data, strides=strides)
    return _without_padding(samples, rows, message.encoding), rows.notes


def _is_smoother(data: Shaped[Array, " bytes"], dtype: np.dtype[Any], rows: Rows, step: int, row: int) -> bool:
    """Whether rows are like the next ones by another step, and not by the stated one."""
    return _unlikeness(data, dtype, rows.height, step, row) * _UNLIKE < _unlikeness(
        data, dtype, rows.height, rows.step, row
    )


def _unlikeness(data: Shaped[Array, " bytes"], dtype: np.dtype[Any], height: int, step: int, row: int) -> float:
    """How much a few rows of the first plane differ from the next ones."""
    every = max(1, height // _ROWS_LOOKED_AT)
    pairs = [
        (data[at : at + row], data[at + step : at + step + row]) for at in range(0, (height - 1) * step, every * step)
    ]
    return sum(float(np.abs(_numbers(a, dtype) - _numbers(b, dtype)).mean()) for a, b in pairs)


def _numbers(row: Shaped[Array, " bytes"], dtype: np.dtype[Any]) -> Shaped[Array, " samples"]:
    return np.frombuffer(row.tobytes(), dtype).astype(np.int32)


def _without_padding(
    samples: Shaped[Array, "rows w *channels"], rows: Rows, encoding: str
) -> Shaped[Array, "fewer w *channels"]:
    """The rows of all planes, without those that are padding behind each."""
    if not rows.luma_rows:
        return samples
    chroma = samples[rows.luma_rows :]
    if encoding.lower() in _ONE_STEP:
        return np.concatenate([samples[: rows.height], chroma[: len(chroma) * rows.height // rows.luma_rows]])
    of_one = rows.height * rows.width // 4
    planes = chroma.reshape(2, -1)[:, :of_one].reshape(-1, rows.width)
    return np.concatenate([samples[: rows.height], planes])
