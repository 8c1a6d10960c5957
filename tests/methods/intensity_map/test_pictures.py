"""Pictures and videos of maps: the front is up, the left is to the left."""

from fractions import Fraction
from pathlib import Path

import av
import cv2
import numpy as np
import pytest
from mapped_factory import mapped_anything, mapped_points
from numpy.typing import NDArray

from navtool.methods.along.pictures import png_bytes
from navtool.methods.along.video import VideoStream
from navtool.methods.intensity_map.pictures import SIDE_PX, draw_map, legend_colours


def classes_panel(sheet: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """The first panel, red first: below its title, at the left."""
    return sheet[34 : 34 + SIDE_PX, 8 : 8 + SIDE_PX, ::-1]


@pytest.mark.parametrize(
    ("x", "y", "up", "left"), [(3.0, 0.0, True, None), (-3.0, 2.0, False, True), (3, -2, True, False)]
)
def test_the_front_is_up_and_the_left_to_the_left(x: float, y: float, up: bool, left: bool | None) -> None:
    near = np.linspace(-0.2, 0.2, 50, dtype=np.float32)
    xyz = np.stack([near + np.float32(x), near + np.float32(y), near], axis=1)
    panel = classes_panel(draw_map(mapped_points(xyz, np.full(50, 250, np.float32)), 0.0))
    rows, columns = np.nonzero((panel == legend_colours()["solid"]).all(axis=2))
    assert rows.size > 50
    assert bool(rows.mean() < SIDE_PX / 2) == up
    assert left is None or bool(columns.mean() < SIDE_PX / 2) == left


def test_every_class_has_its_share_of_the_panel() -> None:
    mapped = mapped_anything(place=None)
    panel = classes_panel(draw_map(mapped, 0.0))
    for number, (name, colour) in enumerate(legend_colours().items()):
        share = float((panel == colour).all(axis=2).mean())
        cells = float((mapped.classes == number).mean())
        assert share == pytest.approx(cells, abs=0.03), name


def test_a_picture_is_a_png_of_even_sides() -> None:
    sheet = draw_map(mapped_anything(), 1.5)
    assert sheet.shape[0] % 2 == sheet.shape[1] % 2 == 0
    back = cv2.imdecode(np.frombuffer(png_bytes(sheet), np.uint8), cv2.IMREAD_COLOR)
    assert back is not None
    np.testing.assert_array_equal(back, sheet)


def test_pictures_do_not_share_what_is_drawn_on_them() -> None:
    first = draw_map(mapped_anything(0), 0.0).copy()
    draw_map(mapped_anything(1), 9.0)
    np.testing.assert_array_equal(draw_map(mapped_anything(0), 0.0), first)


def test_a_video_has_a_frame_a_map_at_its_rate(tmp_path: Path) -> None:
    sheets = [draw_map(mapped_anything(number), number / 5) for number in range(4)]
    for name in ("one.mp4", "two.mp4"):
        with VideoStream(tmp_path / name, Fraction(5)) as video:
            for sheet in sheets:
                video.add(sheet)
    assert (tmp_path / "one.mp4").read_bytes() == (tmp_path / "two.mp4").read_bytes()
    with av.open(str(tmp_path / "one.mp4")) as container:
        frames = list(container.decode(video=0))
        assert container.streams.video[0].average_rate == 5
    assert [frame.time for frame in frames] == pytest.approx([0.0, 0.2, 0.4, 0.6])
    for frame, sheet in zip(frames, sheets, strict=True):
        shown = frame.to_ndarray(format="bgr24")
        assert float(np.abs(shown.astype(np.int16) - sheet).mean()) < 8
