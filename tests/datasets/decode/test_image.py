"""Images of every encoding, raw and compressed, against what they were made from."""

from collections.abc import Callable
from typing import Any

import cv2
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from jaxtyping import UInt8

from navtool.base.errors import DatasetsError
from navtool.datasets.decode.compressed_image import decode_still
from navtool.datasets.decode.encoded_size import encoded_size
from navtool.datasets.decode.image import decode_image
from navtool.datasets.decode.picture_view import Colours, PictureView
from navtool.pipeline.arrays import Array

IMAGE = "sensor_msgs/msg/Image"
COMPRESSED = "sensor_msgs/msg/CompressedImage"
COLOURS = {"r": 0, "g": 1, "b": 2}
type Make = Callable[..., Any]
type Rgb = UInt8[Array, "h w 3"]


def random_rgb(height: int, width: int, seed: int = 0) -> Rgb:
    return np.random.default_rng(seed).integers(0, 256, (height, width, 3), dtype=np.uint8)


def smooth_rgb(height: int = 48, width: int = 64) -> Rgb:
    y, x = np.mgrid[0:height, 0:width]
    return np.stack([x * 255 // width, y * 255 // height, (x + y) * 255 // (width + height)], axis=-1).astype(np.uint8)


def image_fields(samples: Any, encoding: str, *, padding: int = 0, big_endian: bool = False) -> dict[str, Any]:
    """The fields of an image whose rows of samples are padded with bytes that must not matter."""
    height, width = samples.shape[:2]
    rows = samples.reshape(height, -1)
    rows = rows.astype(rows.dtype.newbyteorder(">" if big_endian else "<")).view(np.uint8)
    padded = np.concatenate([rows, np.full((height, padding), 0xAB, np.uint8)], axis=1)
    return {
        "height": height,
        "width": width,
        "encoding": encoding,
        "is_bigendian": int(big_endian),
        "step": padded.shape[1],
        "data": padded.reshape(-1),
    }


def grey(samples: UInt8[Array, "h w"]) -> Rgb:
    return np.repeat(samples[..., None], 3, axis=-1)


@pytest.mark.parametrize("encoding", ["rgb8", "bgr8", "rgba8", "bgra8"])
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=20, deadline=None)
@given(height=st.integers(1, 9), width=st.integers(1, 9), padding=st.integers(0, 7))
def test_colours_and_rows_come_out_in_order(
    encoding: str, height: int, width: int, padding: int, ros_message: Make
) -> None:
    rgb = random_rgb(height, width)
    planes = {"r": rgb[..., 0], "g": rgb[..., 1], "b": rgb[..., 2], "a": np.full((height, width), 7, np.uint8)}
    samples = np.stack([planes[channel] for channel in encoding[:-1]], axis=-1)
    message = ros_message(IMAGE, image_fields(samples, encoding, padding=padding))
    frame = decode_image(message)
    np.testing.assert_array_equal(frame.rgb, rgb)
    assert frame.encoding == encoding


@pytest.mark.parametrize("encoding", ["mono8", "8UC1"])
def test_grey_has_three_equal_channels(encoding: str, ros_message: Make) -> None:
    samples = random_rgb(5, 7)[..., 0]
    frame = decode_image(ros_message(IMAGE, image_fields(samples, encoding, padding=3)))
    np.testing.assert_array_equal(frame.rgb, grey(samples))


@pytest.mark.parametrize("big_endian", [True, False])
def test_grey_of_16_bits_keeps_its_upper_byte_in_either_byte_order(big_endian: bool, ros_message: Make) -> None:
    samples = np.random.default_rng(0).integers(0, 65536, (5, 7), dtype=np.uint16)
    frame = decode_image(ros_message(IMAGE, image_fields(samples, "mono16", padding=2, big_endian=big_endian)))
    np.testing.assert_array_equal(frame.rgb, grey((samples >> 8).astype(np.uint8)))


@pytest.mark.parametrize("bits", [8, 16])
@pytest.mark.parametrize("pattern", ["rggb", "bggr", "gbrg", "grbg"])
def test_a_mosaic_of_one_colour_is_that_colour(pattern: str, bits: int, ros_message: Make) -> None:
    colour = np.array([200, 90, 30])
    mosaic = np.tile(colour[[COLOURS[c] for c in pattern]].reshape(2, 2), (6, 8))
    samples = mosaic.astype(np.uint8) if bits == 8 else (mosaic * 256 + 99).astype(np.uint16)
    frame = decode_image(ros_message(IMAGE, image_fields(samples, f"bayer_{pattern}{bits}", padding=4)))
    np.testing.assert_array_equal(frame.rgb, np.broadcast_to(colour, (12, 16, 3)))


def bt601(y: Any, u: Any, v: Any) -> Any:
    """ITU-R BT.601 with the narrow range of video."""
    luma = 1.164 * (y.astype(float) - 16)
    blue, red = u.astype(float) - 128, v.astype(float) - 128
    rgb = np.stack([luma + 1.596 * red, luma - 0.391 * blue - 0.813 * red, luma + 2.018 * blue], axis=-1)
    return np.clip(rgb, 0, 255)


@pytest.mark.parametrize(
    ("encoding", "luma_first"), [("yuv422", False), ("uyvy", False), ("yuv422_yuy2", True), ("yuyv", True)]
)
def test_luma_and_chroma_of_video_become_colours(encoding: str, luma_first: bool, ros_message: Make) -> None:
    rng = np.random.default_rng(0)
    y = rng.integers(16, 236, (6, 8), dtype=np.uint8)
    u, v = rng.integers(16, 241, (2, 6, 4), dtype=np.uint8)
    chroma = np.stack([u, v], axis=-1).reshape(6, 8)
    samples = np.stack([y, chroma] if luma_first else [chroma, y], axis=-1)
    frame = decode_image(ros_message(IMAGE, image_fields(samples, encoding, padding=2)))
    expected = bt601(y, np.repeat(u, 2, axis=1), np.repeat(v, 2, axis=1))
    assert np.abs(frame.rgb - expected).max() <= 2


def test_an_rgb_image_is_not_copied(ros_message: Make) -> None:
    message = ros_message(IMAGE, image_fields(random_rgb(4, 4), "rgb8"))
    assert np.shares_memory(decode_image(message).rgb, message.data)


def test_the_padding_of_the_last_row_may_be_left_out(ros_message: Make) -> None:
    fields = image_fields(random_rgb(4, 4), "rgb8", padding=5)
    frame = decode_image(ros_message(IMAGE, {**fields, "data": fields["data"][:-5]}))
    np.testing.assert_array_equal(frame.rgb, random_rgb(4, 4))


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"data": np.zeros(47)}, "truncated image: 47 bytes of pixels, but its size needs 48"),
        ({"data": np.zeros(0)}, "truncated image: 0 bytes"),
        ({"encoding": "nv12", "width": 3}, "3 x 4 nv12 pixels, of which two share their chroma"),
        ({"width": 0, "step": 0}, "an image of 0 x 4 pixels"),
        ({"height": 0}, "an image of 4 x 0 pixels"),
        ({"encoding": "16UC1"}, "depth image"),
        ({"encoding": "32FC1"}, "depth image"),
        ({"encoding": "h264"}, "image encoding 'h264' is not supported; rgb8, bgr8"),
    ],
)
def test_a_faulty_image_is_refused_with_the_reason(change: dict[str, Any], told: str, ros_message: Make) -> None:
    fields = {**image_fields(random_rgb(4, 4), "rgb8"), **change}
    with pytest.raises(DatasetsError, match=told):
        decode_image(ros_message(IMAGE, fields))


def encoded(pixels: Any, suffix: str) -> UInt8[Array, " n"]:
    """Compressed as OpenCV does it, which takes colours in the order blue, green, red."""
    ordered = pixels[..., ::-1] if pixels.ndim == 3 else pixels
    done, data = cv2.imencode(suffix, np.ascontiguousarray(ordered))
    assert done
    return np.asarray(data, np.uint8)


@pytest.mark.parametrize("form", ["jpeg", "jpg", "", "rgb8; jpeg compressed bgr8", "bgr8; jpeg compressed bgr8"])
def test_a_jpeg_image_is_close_to_what_was_compressed(form: str, ros_message: Make) -> None:
    frame = decode_still(
        ros_message(COMPRESSED, {"format": form, "data": encoded(smooth_rgb(), ".jpg"), "header": {"frame_id": "cam"}})
    )
    assert frame.encoding == "jpeg"
    assert frame.frame_id == "cam"
    assert np.abs(frame.rgb.astype(int) - smooth_rgb()).mean() < 3


@pytest.mark.parametrize("form", ["png", "bgr8; png compressed bgr8"])
def test_a_png_image_is_exactly_what_was_compressed(form: str, ros_message: Make) -> None:
    frame = decode_still(ros_message(COMPRESSED, {"format": form, "data": encoded(random_rgb(9, 7), ".png")}))
    np.testing.assert_array_equal(frame.rgb, random_rgb(9, 7))
    assert frame.encoding == "png"


def test_grey_and_16_bit_compressed_images_become_rgb(ros_message: Make) -> None:
    samples = np.random.default_rng(0).integers(0, 65536, (5, 7), dtype=np.uint16)
    for pixels in ((samples >> 8).astype(np.uint8), samples):
        frame = decode_still(ros_message(COMPRESSED, {"format": "png", "data": encoded(pixels, ".png")}))
        np.testing.assert_allclose(frame.rgb, grey((samples >> 8).astype(np.uint8)), atol=1)


def test_an_image_compressed_with_red_and_blue_exchanged_is_put_right(ros_message: Make) -> None:
    data = encoded(random_rgb(5, 7)[..., ::-1], ".png")
    frame = decode_still(ros_message(COMPRESSED, {"format": "rgb8; png compressed rgb8", "data": data}))
    np.testing.assert_array_equal(frame.rgb, random_rgb(5, 7))


def test_a_compressed_mosaic_is_demosaiced(ros_message: Make) -> None:
    colour = np.array([200, 90, 30])
    mosaic = np.tile(colour[[0, 1, 1, 2]].reshape(2, 2), (6, 8)).astype(np.uint8)
    fields = {"format": "bayer_rggb8; png compressed ", "data": encoded(mosaic, ".png")}
    frame = decode_still(ros_message(COMPRESSED, fields))
    np.testing.assert_array_equal(frame.rgb, np.broadcast_to(colour, (12, 16, 3)))


def test_an_image_keeps_the_sensors_orientation_whatever_exif_says(ros_message: Make) -> None:
    plain = encoded(smooth_rgb(), ".jpg")
    tiff = b"II*\0\x08\0\0\0" + b"\x01\0" + b"\x12\x01\x03\0\x01\0\0\0\x06\0\0\0" + b"\0\0\0\0"
    segment = b"Exif\0\0" + tiff
    turned = bytes(plain[:2]) + b"\xff\xe1" + (len(segment) + 2).to_bytes(2, "big") + segment + bytes(plain[2:])
    assert np.asarray(cv2.imdecode(np.frombuffer(turned, np.uint8), cv2.IMREAD_COLOR)).shape == (64, 48, 3)
    frame = decode_still(ros_message(COMPRESSED, {"format": "jpeg", "data": np.frombuffer(turned, np.uint8)}))
    assert frame.rgb.shape == (48, 64, 3)


@pytest.mark.parametrize("suffix", [".jpg", ".png"])
def test_a_truncated_compressed_image_is_refused(suffix: str, ros_message: Make) -> None:
    data = encoded(random_rgb(40, 50), suffix)
    for size in (0, 5, 30, len(data) // 2, len(data) - 3):
        with pytest.raises(DatasetsError, match=r"truncated|damaged|neither"):
            decode_still(ros_message(COMPRESSED, {"format": suffix[1:], "data": data[:size]}))


@pytest.mark.parametrize("options", [[], [cv2.IMWRITE_JPEG_PROGRESSIVE, 1]])
@pytest.mark.parametrize("suffix", [".jpg", ".png"])
def test_the_size_that_an_image_states_is_its_own(suffix: str, options: list[int]) -> None:
    _, data = cv2.imencode(suffix, np.zeros((48, 64, 3), np.uint8), options if suffix == ".jpg" else [])
    assert encoded_size(data.tobytes()) == (64, 48)
    assert encoded_size(b"\xff\xd8\xff" + bytes(20)) == (0, 0)


def test_a_damaged_size_fills_no_gigabytes(ros_message: Make) -> None:
    stated = (30_000).to_bytes(2, "big") * 2
    jpeg = encoded(random_rgb(48, 64), ".jpg").tobytes()
    place = jpeg.index(b"\xff\xc0") + 5
    png = encoded(random_rgb(48, 64), ".png").tobytes()
    damaged = (
        (jpeg[:place] + stated + jpeg[place + 4 :], "jpeg"),
        (png[:16] + (1 << 20).to_bytes(4, "big") * 2 + png[24:], "png"),
    )
    for data, form in damaged:
        pixels = np.frombuffer(data, np.uint8)
        with pytest.raises(DatasetsError, match=r"damaged image .* it says that it has"):
            decode_still(ros_message(COMPRESSED, {"format": form, "data": pixels}))
    # A driver that publishes a JPEG under the name of raw pixels.
    fields = {**image_fields(random_rgb(4, 4), "rgb8"), "width": 640, "height": 480, "step": 1920}
    with pytest.raises(DatasetsError, match="it says that it has"):
        decode_image(ros_message(IMAGE, {**fields, "data": np.frombuffer(damaged[0][0], np.uint8)}))


@pytest.mark.parametrize(
    ("form", "told"),
    [
        ("16UC1; compressedDepth", "depth image"),
        ("16UC1; png compressed ", "depth image"),
        ("compressedDepth png", "depth image"),
        ("h264", "neither JPEG nor PNG; the message calls it 'h264'"),
    ],
)
def test_other_compressions_are_refused_with_the_reason(form: str, told: str, ros_message: Make) -> None:
    with pytest.raises(DatasetsError, match=told):
        decode_still(ros_message(COMPRESSED, {"format": form, "data": np.arange(100)}))


def in_planes(rgb: Rgb, kind: str) -> Any:
    """A picture as rows of luma and chroma, which two columns and two rows share."""
    planar = np.asarray(cv2.cvtColor(rgb, cv2.COLOR_RGB2YUV_I420), np.uint8)
    height, width = rgb.shape[:2]
    luma, u, v = planar[:height], planar[height : height * 5 // 4].ravel(), planar[height * 5 // 4 :].ravel()
    chroma = {"i420": [u, v], "yv12": [v, u]}
    if kind in chroma:
        return np.concatenate([luma.ravel(), *chroma[kind]]).reshape(-1, width)
    pairs = np.stack([u, v] if kind != "nv21" else [v, u], axis=-1).reshape(height // 2, width)
    if kind == "nv16":
        return np.concatenate([luma, np.repeat(pairs, 2, axis=0)])
    if kind == "nv24":
        whole = np.repeat(np.repeat(pairs.reshape(height // 2, width // 2, 2), 2, axis=0), 2, axis=1)
        return np.concatenate([luma, whole.reshape(-1, width)])
    return np.concatenate([luma, pairs])


@pytest.mark.parametrize("kind", ["nv12", "nv21", "i420", "yuv420", "yv12", "nv16", "nv24"])
def test_pictures_in_planes_become_colours(kind: str, ros_message: Make) -> None:
    rgb = smooth_rgb()
    samples = in_planes(rgb, "i420" if kind == "yuv420" else kind)
    fields = {**image_fields(rgb[..., 0], kind), "data": samples.reshape(-1)}
    frame = decode_image(ros_message(IMAGE, fields))
    assert np.abs(frame.rgb.astype(int) - rgb).mean() < 3
    if kind in ("nv12", "nv21", "nv16"):
        padded = np.concatenate([samples, np.full((len(samples), 6), 0xAB, np.uint8)], axis=1)
        wide = {**fields, "step": padded.shape[1], "data": padded.reshape(-1)}
        np.testing.assert_array_equal(decode_image(ros_message(IMAGE, wide)).rgb, frame.rgb)


@pytest.mark.parametrize("kind", ["nv12", "nv21", "i420", "yv12", "nv16"])
def test_rows_between_luma_and_chroma_are_left_out(kind: str, ros_message: Make) -> None:
    rgb = smooth_rgb(40)
    height, width = rgb.shape[:2]
    samples = in_planes(rgb, kind)
    split = np.split(samples.ravel(), [height * width, height * width * 5 // 4]) if kind in ("i420", "yv12") else None
    planes = split or [samples[:height].ravel(), samples[height:].ravel()]
    aligned = [np.concatenate([plane, np.full(len(plane) // 5, 0xAB, np.uint8)]) for plane in planes]  # 48 rows, not 40
    fields = {**image_fields(rgb[..., 0], kind), "data": np.concatenate(aligned)}
    frame = decode_image(ros_message(IMAGE, fields))
    right = decode_image(ros_message(IMAGE, {**fields, "data": samples.ravel()}))
    np.testing.assert_array_equal(frame.rgb, right.rgb)
    assert [note.code for note in frame.notes] == ["image.size-misfit"]


@pytest.mark.parametrize("kind", ["rgb8", "mono8", "nv12", "rgb16"])
def test_rows_that_are_longer_than_their_step_are_seen_by_their_pixels(kind: str, ros_message: Make) -> None:
    rgb = smooth_rgb()
    samples = {"mono8": rgb[..., 0], "rgb16": rgb.astype(np.uint16) * 257}.get(kind, rgb)
    samples = in_planes(rgb, kind) if kind == "nv12" else samples
    tight = image_fields(samples, kind)
    size = {"height": len(rgb), "step": tight["step"]}
    right = decode_image(ros_message(IMAGE, {**tight, **size}))
    frame = decode_image(ros_message(IMAGE, {**image_fields(samples, kind, padding=24), **size}))
    np.testing.assert_array_equal(frame.rgb, right.rgb)
    assert [note.code for note in frame.notes] == ["image.size-misfit"]
    assert not right.notes


@pytest.mark.parametrize("kind", ["8UC3", "8UC4", "BGR8", "rgb16", "bgr16", "rgba16", "bgra16", "16UC3"])
def test_channels_without_names_are_opencvs_and_16_bits_keep_their_upper_byte(kind: str, ros_message: Make) -> None:
    rgb = smooth_rgb()
    ordered = rgb if kind.startswith("rgb") else rgb[..., ::-1]
    samples = np.ascontiguousarray(ordered if "16" not in kind else ordered.astype(np.uint16) * 257)
    if kind in ("8UC4", "rgba16", "bgra16"):
        samples = np.concatenate([samples, np.full_like(samples[..., :1], 9)], axis=-1)
    frame = decode_image(ros_message(IMAGE, image_fields(samples, kind)))
    np.testing.assert_array_equal(frame.rgb, rgb)


@pytest.mark.parametrize(
    "change",
    [{"step": 0}, {"step": 64}, {"step": 191}, {"step": 5000}, {"width": 48, "height": 64}],
    ids=["never set", "in pixels", "too small", "too large", "width and height exchanged"],
)
def test_what_fits_the_bytes_counts_against_step_and_size(change: dict[str, int], ros_message: Make) -> None:
    fields = {**image_fields(smooth_rgb(), "rgb8"), **change}
    frame = decode_image(ros_message(IMAGE, fields))
    np.testing.assert_array_equal(frame.rgb, smooth_rgb())
    assert [note.code for note in frame.notes] == ["image.size-misfit"]


def test_bytes_behind_the_last_row_and_padding_without_a_step_are_no_pixels(ros_message: Make) -> None:
    fields = image_fields(smooth_rgb(), "rgb8")
    longer = np.concatenate([fields["data"], np.zeros(192 * 8, np.uint8)])
    for step in (192, 0):
        frame = decode_image(ros_message(IMAGE, {**fields, "step": step, "data": longer}))
        np.testing.assert_array_equal(frame.rgb, smooth_rgb())
    padded = image_fields(smooth_rgb(), "rgb8", padding=26)
    np.testing.assert_array_equal(decode_image(ros_message(IMAGE, {**padded, "step": 0})).rgb, smooth_rgb())


@pytest.mark.parametrize("said", [True, False])
@pytest.mark.parametrize("truly", [True, False])
def test_the_order_of_bytes_that_is_a_picture_counts(truly: bool, said: bool, ros_message: Make) -> None:
    rng = np.random.default_rng(1)
    samples = (smooth_rgb()[..., 0].astype(np.uint16) * 24 + 7076 + rng.integers(0, 9, (48, 64))).astype(np.uint16)
    fields = {**image_fields(samples, "mono16", big_endian=truly), "is_bigendian": int(said)}
    frame = decode_image(ros_message(IMAGE, fields))
    assert frame.deep is not None
    np.testing.assert_array_equal(frame.deep.samples, samples)
    assert bool(frame.notes) == (truly != said)


@pytest.mark.parametrize("bits", [10, 12, 14])
def test_the_order_of_bytes_is_seen_by_the_bits_that_are_never_used(bits: int, ros_message: Make) -> None:
    samples = smooth_rgb()[..., 0].astype(np.uint16) << (bits - 8)
    frame = decode_image(ros_message(IMAGE, {**image_fields(samples, "mono16"), "is_bigendian": 1}))
    assert frame.deep is not None
    np.testing.assert_array_equal(frame.deep.samples, samples)
    assert [note.code for note in frame.notes] == ["image.size-misfit"]


@pytest.mark.parametrize("shift", [0, 4, 8])
def test_the_order_of_bytes_is_believed_where_both_are_pictures(shift: int, ros_message: Make) -> None:
    samples = smooth_rgb()[..., 0].astype(np.uint16) << shift
    frame = decode_image(ros_message(IMAGE, image_fields(samples, "mono16", big_endian=True)))
    assert frame.deep is not None
    np.testing.assert_array_equal(frame.deep.samples, samples)
    assert not frame.notes


@pytest.mark.parametrize("form", ["mono16; png compressed ", "png"])
def test_a_compressed_picture_of_16_bits_keeps_them(form: str, ros_message: Make) -> None:
    samples = (smooth_rgb()[..., 0].astype(np.uint16) * 3) + 7076
    frame = decode_still(ros_message(COMPRESSED, {"format": form, "data": encoded(samples, ".png")}))
    assert frame.deep is not None
    np.testing.assert_array_equal(frame.deep.samples, samples)


def test_what_a_format_says_of_colours_is_noted_and_can_be_overruled(ros_message: Make) -> None:
    data = encoded(smooth_rgb(), ".png")
    frame = decode_still(ros_message(COMPRESSED, {"format": "rgb8; png compressed rgb8", "data": data}))
    assert [note.code for note in frame.notes] == ["image.colours-exchanged"]
    np.testing.assert_array_equal(frame.rgb, smooth_rgb()[..., ::-1])
    held = PictureView(colours=Colours.as_held).shown(frame)
    np.testing.assert_array_equal(held.rgb, smooth_rgb())
    plain = decode_still(ros_message(COMPRESSED, {"format": "jpeg", "data": data}))
    assert [note.code for note in plain.notes] == ["image.label"]
    np.testing.assert_array_equal(PictureView(colours=Colours.as_held).shown(plain).rgb, smooth_rgb())
    np.testing.assert_array_equal(PictureView(colours=Colours.exchanged).shown(plain).rgb, smooth_rgb()[..., ::-1])
