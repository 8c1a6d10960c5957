"""Pictures as other people's cameras write them, through to the rows: image_encodings, image_shape."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from field_drives import HEIGHT, WIDTH, Rows, camera_drive, header, likeness, picture, raw, rows_of
from hashes import hashes
from ingesting import ingested as ingest_report
from noted import noted

from navtool.datasets.inspect.inspection import inspect_recording
from navtool.datasets.robot.config import RobotConfig
from navtool.datasets.robot.sensor_config import PictureSettings

type Make = Callable[..., Any]


def grey(number: int) -> Any:
    return cv2.cvtColor(picture(number), cv2.COLOR_RGB2GRAY).astype(np.uint16)


def ingest(make: Callable[[int, int], dict[str, Any]], writer: Make, folder: Path, **options: Any) -> Rows:
    return rows_of(writer(folder, "mcap", camera_drive(make)), folder / "dataset", **options)


def assert_each_row_shows_its_own(rows: Rows, *, alike: float = 0.97) -> None:
    assert rows.column("valid.camera").all()
    for number, shown in enumerate(rows.pictures):
        assert likeness(shown, picture(number)) > alike
        assert shown.std() > 30, "bright enough to see something"


@pytest.mark.parametrize(
    ("encoding", "offset", "gain", "range_"),
    [
        ("mono16", 7076, 3, "a band"),
        ("mono16", 0, 4, "0 to 1023"),
        ("mono16", 0, 16, "0 to 4095"),
        ("mono16", 0, 64, "0 to 16383"),
        ("mono16", 0, 257, ""),
        ("bayer_rggb16", 0, 16, "0 to 4095"),
        ("bayer_gbrg16", 0, 4, "0 to 1023"),
    ],
)
def test_deep_pictures_are_bright_and_their_range_is_told(
    encoding: str, offset: int, gain: int, range_: str, recording_writer: Make, tmp_path: Path
) -> None:
    rows = ingest(lambda k, t: raw(t, grey(k) * gain + offset, encoding), recording_writer, tmp_path)
    assert_each_row_shows_its_own(rows)
    told = noted(rows.notes, "image.range")
    assert len(told) == bool(range_)
    if range_.startswith("0"):
        assert f"from {range_} are shown" in told[0]


def test_the_range_of_the_first_seconds_stays_whatever_comes_and_however_many_work(
    recording_writer: Make, tmp_path: Path
) -> None:
    def warmer(number: int, stamp_ns: int) -> dict[str, Any]:
        return raw(stamp_ns, grey(number) * 3 + 7076 + (3000 if number > 35 else 0), "mono16")

    recording = recording_writer(tmp_path, "mcap", camera_drive(warmer, count=45))
    rows = rows_of(recording, tmp_path / "one")
    assert likeness(rows.pictures[20], picture(20)) > 0.97
    assert rows.pictures[44].min() > 240, "beyond the range is white, and told"
    (outside,) = noted(rows.notes, "image.out-of-range")
    assert "(9 messages)" in outside
    rows_of(recording, tmp_path / "two", workers=2)
    assert hashes(tmp_path / "one") == hashes(tmp_path / "two")


def test_a_hand_setting_overrules_range_and_colours(recording_writer: Make, tmp_path: Path) -> None:
    robot = RobotConfig(pictures={"front": PictureSettings(range=[0, 65535])})
    rows = ingest(lambda k, t: raw(t, grey(k) * 16, "mono16"), recording_writer, tmp_path, robot=robot)
    assert rows.pictures[0].max() < 24
    assert not noted(rows.notes, "image.range")


@pytest.mark.parametrize(
    ("encoding", "make"),
    [
        ("8UC3", lambda p: p[..., ::-1]),
        ("8UC4", lambda p: np.dstack([p[..., ::-1], p[..., 0]])),
        ("rgb16", lambda p: p.astype(np.uint16) * 257),
        ("bgr16", lambda p: p[..., ::-1].astype(np.uint16) * 16),
        ("rgba16", lambda p: np.dstack([p, p[..., 0]]).astype(np.uint16) * 257),
    ],
)
def test_encodings_of_other_drivers_keep_their_colours(
    encoding: str, make: Callable[[Any], Any], recording_writer: Make, tmp_path: Path
) -> None:
    rows = ingest(lambda k, t: raw(t, make(picture(k)), encoding), recording_writer, tmp_path)
    assert_each_row_shows_its_own(rows)
    for number, shown in enumerate(rows.pictures):
        assert np.abs(shown.astype(int) - picture(number)).mean() < 12


@pytest.mark.parametrize("encoding", ["nv12", "nv21"])
def test_pictures_in_planes_keep_their_colours(encoding: str, recording_writer: Make, tmp_path: Path) -> None:
    def planes(number: int, stamp_ns: int) -> dict[str, Any]:
        planar = np.asarray(cv2.cvtColor(picture(number), cv2.COLOR_RGB2YUV_I420))
        u, v = planar[HEIGHT : HEIGHT * 5 // 4].ravel(), planar[HEIGHT * 5 // 4 :].ravel()
        pairs = np.stack([u, v] if encoding == "nv12" else [v, u], axis=-1).ravel()
        data = np.concatenate([planar[:HEIGHT].ravel(), pairs])
        return {**raw(stamp_ns, planar[:HEIGHT], encoding), "data": data}

    rows = ingest(planes, recording_writer, tmp_path)
    assert_each_row_shows_its_own(rows)
    assert np.abs(rows.pictures[3].astype(int) - picture(3)).mean() < 12


@pytest.mark.parametrize("kind", ["padded", "step zero", "step in pixels", "tail", "big-endian"])
def test_image_shape_as_it_is(kind: str, recording_writer: Make, tmp_path: Path) -> None:
    def make(number: int, stamp_ns: int) -> dict[str, Any]:
        pixels = picture(number)
        if kind == "padded":
            padded = np.concatenate([pixels.reshape(HEIGHT, -1), np.full((HEIGHT, 26), 255, np.uint8)], axis=1)
            return raw(stamp_ns, padded, "rgb8", width=WIDTH)
        if kind == "big-endian":
            return raw(stamp_ns, (grey(number) * 256).byteswap(), "mono16", is_bigendian=1)
        fields = raw(stamp_ns, pixels, "rgb8")
        longer = np.concatenate([fields["data"], np.zeros(960 * 8, np.uint8)])
        return {
            **fields,
            **{"step zero": {"step": 0}, "step in pixels": {"step": WIDTH}, "tail": {"data": longer}}[kind],
        }

    rows = ingest(make, recording_writer, tmp_path)
    assert_each_row_shows_its_own(rows)
    assert bool(noted(rows.notes, "image.size-misfit")) == kind.startswith("step")


def test_image_shape_that_changes_within_a_run(recording_writer: Make, tmp_path: Path) -> None:
    def turned(number: int, stamp_ns: int) -> dict[str, Any]:
        return raw(stamp_ns, picture(number) if number < 6 else np.rot90(picture(number)), "rgb8")

    def smaller(number: int, stamp_ns: int) -> dict[str, Any]:
        return raw(stamp_ns, picture(number)[:: 1 + number // 6, :: 1 + number // 6], "rgb8")

    (note,) = noted(ingest(turned, recording_writer, tmp_path / "a").notes, "image.other-shape")
    assert "240x320 among those of 320x240" in note
    assert "(6 messages)" in note
    rows = ingest(smaller, recording_writer, tmp_path / "b")
    assert not noted(rows.notes, "image.other-shape")
    assert_each_row_shows_its_own(rows, alike=0.9)


@pytest.mark.parametrize(
    ("form", "given", "codes"),
    [
        ("bgr8; jpeg compressed bgr8", "bgr", []),
        ("rgb8; jpeg compressed bgr8", "bgr", []),
        ("jpeg", "bgr", []),
        ("rgb8; jpeg compressed rgb8", "rgb", ["image.colours-exchanged"]),
        ("png", "bgr", ["image.label"]),
    ],
)
def test_colours_of_compressed_pictures(
    form: str, given: str, codes: list[str], recording_writer: Make, tmp_path: Path
) -> None:
    def make(number: int, stamp_ns: int) -> dict[str, Any]:
        pixels = picture(number) if given == "rgb" else picture(number)[..., ::-1]
        return {
            **header(stamp_ns),
            "format": form,
            "data": cv2.imencode(".jpg", np.ascontiguousarray(pixels))[1].ravel(),
        }

    entries = camera_drive(make, kind="sensor_msgs/msg/CompressedImage", topic="/camera/image_raw/compressed")
    rows = rows_of(recording_writer(tmp_path, "mcap", entries), tmp_path / "dataset")
    assert_each_row_shows_its_own(rows)
    assert np.abs(rows.pictures[3].astype(int) - picture(3)).mean() < 12
    assert [note.code for note in rows.notes if note.code.startswith("image.")] == codes


def test_inspect_says_the_same_of_pictures_before_anything_is_written(recording_writer: Make, tmp_path: Path) -> None:
    recording = recording_writer(
        tmp_path, "mcap", camera_drive(lambda k, t: raw(t, grey(k) * 3 + 7076, "mono16", step=0))
    )
    planned = ingest_report([recording], tmp_path / "out", dry_run=True)
    seen = inspect_recording(recording).notes
    for code in ("image.range", "image.size-misfit"):
        assert noted(seen, code) == noted(planned.episodes[0].notes, code) != []
