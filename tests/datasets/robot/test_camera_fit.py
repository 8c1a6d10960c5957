"""A calibration of the whole sensor brought to the pictures that a camera sends (REP 104)."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from navtool.datasets.decode.messages import Region
from navtool.datasets.robot.camera_fit import fitted
from navtool.pipeline.geometry.camera import CameraModel

Floats = NDArray[np.float64]
LENS = (-0.28, 0.07, 0.001, -0.0007, 0.01)
CAMERA = CameraModel(640, 480, 500.0, 510.0, 321.0, 238.0, "plumb_bob", LENS)
POINTS = np.array([[0.1, 0.2, 1.0], [-0.2, 0.15, 2.0], [0.05, 0.1, 1.5]])


def by_opencv(points: Floats) -> Floats:
    matrix = np.array([[500.0, 0, 321.0], [0, 510.0, 238.0], [0, 0, 1]])
    pixels, _ = cv2.projectPoints(points, np.zeros(3), np.zeros(3), matrix, np.array(LENS))
    return np.asarray(pixels, np.float64).reshape(-1, 2)


@pytest.mark.parametrize("offset", [(0, 240), (100, 0), (37, 61)])
def test_a_region_of_interest_moves_what_the_whole_sensor_sees_and_scales_nothing(offset: tuple[int, int]) -> None:
    size = 640 - offset[0], 480 - offset[1]
    found = fitted(CAMERA, Region(offset=offset, size=size), size)
    assert (found.camera.fx, found.camera.fy) == (500.0, 510.0)
    np.testing.assert_allclose(found.camera.project(POINTS).pixels, by_opencv(POINTS) - offset, atol=1e-9)
    assert not found.notes
    assert "region of interest" in found.done


def test_binning_scales_and_a_region_is_cut_out_before_it() -> None:
    binned = fitted(CAMERA, Region(binning=(2, 2)), (320, 240))
    assert binned.camera == CAMERA
    assert not binned.notes
    part = fitted(CAMERA, Region(offset=(100, 200), size=(400, 240), binning=(2, 2)), (200, 120))
    assert part.camera == replace(CAMERA, width=400, height=240, cx=221.0, cy=38.0)
    assert not part.notes
    lines = fitted(CAMERA, Region(binning=(1, 2)), (640, 240))
    assert not lines.notes, "two rows are one: the pictures are the whole sensor's all the same"


def test_pictures_of_the_whole_sensor_or_of_nothing_it_says_leave_the_region_out() -> None:
    region = Region(offset=(0, 240), size=(640, 240))
    for seen in ((640, 480), (320, 240)):
        found = fitted(CAMERA, region, seen)
        assert found.camera == CAMERA
        assert [note.code for note in found.notes] == ["camera.region-unused"]
    outside = fitted(CAMERA, Region(offset=(600, 0), size=(100, 480)), (640, 480))
    assert outside.camera == CAMERA
    assert [note.code for note in outside.notes] == ["camera.region-unused"]
    assert fitted(CAMERA, Region(size=(640, 480)), (640, 480)) == (CAMERA, "", ())


@pytest.mark.parametrize("seen", [(640, 360), (480, 640), (848, 480)])
def test_pictures_of_another_shape_are_told(seen: tuple[int, int]) -> None:
    (note,) = fitted(CAMERA, Region(), seen).notes
    assert note.code == "camera.other-shape"
    assert f"{seen[0]}x{seen[1]}" in note.text


@pytest.mark.parametrize("seen", [(640, 480), (320, 240), (1280, 960), (213, 160), (641, 480), (1241, 931)])
def test_pictures_of_the_same_shape_are_not(seen: tuple[int, int]) -> None:
    assert not fitted(CAMERA, Region(), seen).notes
