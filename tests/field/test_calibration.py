"""Cameras that read out a part of their sensor or bin it, through to calibration.json: camera_info_roi."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from drive_factory import START_NS
from field_drives import camera_drive, header, picture, raw, rows_of
from noted import noted

from navtool.base.note import Note
from navtool.datasets.robot.calibration import read_calibration
from navtool.pipeline.geometry.camera import CameraModel

type Make = Callable[..., Any]
LENS = (-0.28, 0.07, 0.001, -0.0007, 0.01)
POINTS = np.array([[0.1, 0.2, 1.0], [-0.2, 0.15, 2.0], [0.05, 0.1, 1.5]])


def info(
    roi: dict[str, int] | None = None, binning: int = 0, model: str = "plumb_bob", d: Any = LENS
) -> dict[str, Any]:
    """A calibration of the whole sensor, 640x480."""
    return {
        **header(START_NS),
        "width": 640,
        "height": 480,
        "distortion_model": model,
        "d": np.array(d),
        "k": np.array([500.0, 0, 320, 0, 500, 240, 0, 0, 1]),
        "r": np.eye(3).ravel(),
        "p": np.array([500.0, 0, 320, 0, 0, 500, 240, 0, 0, 0, 1, 0]),
        "binning_x": binning,
        "binning_y": binning,
        "roi": roi or {},
    }


def calibrated(
    size: tuple[int, int], fields: dict[str, Any], writer: Make, folder: Path
) -> tuple[CameraModel, list[Note]]:
    """The camera of the rows, 320x240, and what is noted."""
    entries = camera_drive(lambda k, t: raw(t, picture(k, *size), "rgb8"))
    entries.insert(0, ("/camera/camera_info", "sensor_msgs/msg/CameraInfo", START_NS, fields))
    notes = rows_of(writer(folder, "mcap", entries), folder / "dataset").notes
    (path,) = (folder / "dataset").glob("**/calibration.json")
    camera = read_calibration(path).camera
    assert camera is not None
    assert json.loads(path.read_text())["recorded"]["camera_info"]["camera"]["width"] == 640, "kept as recorded"
    return camera, notes


def seen(matrix: Any, model: str = "plumb_bob") -> Any:
    """Where OpenCV sees the points on the whole sensor."""
    zero = np.zeros(3)
    if model == "fisheye":
        pixels, _ = cv2.fisheye.projectPoints(POINTS[:, None], zero, zero, matrix, np.array(LENS[:4]))
    else:
        pixels, _ = cv2.projectPoints(POINTS, zero, zero, matrix, np.array(LENS))
    return np.asarray(pixels).reshape(-1, 2)


WHOLE = np.array([[500.0, 0, 320], [0, 500, 240], [0, 0, 1]])
LOWER = {"x_offset": 0, "y_offset": 240, "width": 640, "height": 240}
MIDDLE = {"x_offset": 100, "y_offset": 60, "width": 400, "height": 300}


@pytest.mark.parametrize(
    ("size", "roi", "binning"),
    [
        ((640, 240), LOWER, 0),
        ((400, 300), MIDDLE, 1),
        ((200, 150), MIDDLE, 2),
        ((320, 240), None, 2),
        ((640, 480), None, 0),
    ],
)
def test_camera_info_roi(
    size: tuple[int, int], roi: dict[str, int] | None, binning: int, recording_writer: Make, tmp_path: Path
) -> None:
    camera, notes = calibrated(size, info(roi, binning), recording_writer, tmp_path)
    shown = (roi["width"], roi["height"]) if roi else (640, 480)
    offset = (roi["x_offset"], roi["y_offset"]) if roi else (0, 0)
    expected = (seen(WHOLE) - offset + 0.5) * (320 / shown[0], 240 / shown[1]) - 0.5
    np.testing.assert_allclose(camera.project(POINTS).pixels, expected, atol=1e-6)
    assert not [note for note in notes if note.code.startswith("camera.")]


@pytest.mark.parametrize("size", [(640, 480), (480, 360)])
def test_a_region_that_is_smaller_than_its_pictures_is_not_believed(
    size: tuple[int, int], recording_writer: Make, tmp_path: Path
) -> None:
    camera, notes = calibrated(size, info(MIDDLE), recording_writer, tmp_path)
    np.testing.assert_allclose(camera.project(POINTS).pixels, (seen(WHOLE) + 0.5) / 2 - 0.5, atol=1e-6)
    (told,) = noted(notes, "camera.region-unused")
    assert f"pictures, {size[0]}x{size[1]}, are larger" in told


def test_pictures_of_another_shape_than_their_calibration_are_told(recording_writer: Make, tmp_path: Path) -> None:
    _, notes = calibrated((640, 360), info(), recording_writer, tmp_path)
    (told,) = noted(notes, "camera.other-shape")
    assert "calibrated at 640x480, pictures of 640x360" in told


@pytest.mark.parametrize("model", ["fisheye", "equidistant", "kannala_brandt4", "Kannala-Brandt"])
def test_fisheye_lenses_by_any_name_are_opencvs(model: str, recording_writer: Make, tmp_path: Path) -> None:
    camera, _ = calibrated((640, 480), info(model=model, d=LENS[:4]), recording_writer, tmp_path)
    np.testing.assert_allclose(camera.project(POINTS).pixels, (seen(WHOLE, "fisheye") + 0.5) / 2 - 0.5, atol=1e-6)


def test_coefficients_without_a_model_are_plumb_bobs_and_told(recording_writer: Make, tmp_path: Path) -> None:
    camera, notes = calibrated((640, 480), info(model=""), recording_writer, tmp_path)
    np.testing.assert_allclose(camera.project(POINTS).pixels, (seen(WHOLE) + 0.5) / 2 - 0.5, atol=1e-6)
    assert len(noted(notes, "camera.lens-name")) == 1
