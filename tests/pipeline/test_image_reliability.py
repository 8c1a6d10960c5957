"""Image reliability: pixels and OpenCV as oracles, laws of gain and blur, and real photos."""

from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays
from numpy.typing import NDArray

from navtool.base.setting_error import SettingError
from navtool.pipeline.image_reliability import ImageReliabilityConfig, count_corners, image_reliability

Image = NDArray[np.uint8]
CONFIG = ImageReliabilityConfig()
LITERAL = ImageReliabilityConfig(corner_density_saturated=1.0)

images = arrays(np.uint8, array_shapes(min_dims=2, max_dims=2, max_side=40).map(lambda shape: (*shape, 3)))


def texture(seed: int = 0, height: int = 120, width: int = 160) -> Image:
    """Bright spots of 3 pixels, brightest in the middle, 7 pixels apart on a dark ground: each a corner."""
    image = np.full((height, width, 3), 40, np.uint8)
    rows, columns = np.meshgrid(np.arange(8, height - 8, 7), np.arange(8, width - 8, 7), indexing="ij")
    shades = np.random.default_rng(seed).integers(120, 256, rows.shape, np.uint8)
    for row in (-1, 0, 1):
        for column in (-1, 0, 1):
            image[rows + row, columns + column] = (shades - 30 * (row != 0 or column != 0))[..., None]
    return image


def blurred(image: Image, sigma: float) -> Image:
    return np.asarray(cv2.GaussianBlur(image, (0, 0), sigma), np.uint8)


@settings(deadline=None)
@given(image=images)
def test_brightness_is_the_rms_of_the_grey_pixels(image: Image) -> None:
    grey = np.rint(image.astype(np.float64) @ [0.299, 0.587, 0.114])
    expected = np.sqrt((grey**2).mean()) / 255
    # OpenCV's fixed-point luma may round half a level the other way.
    assert image_reliability(image, CONFIG).brightness == pytest.approx(expected, abs=0.5 / 255)


@settings(deadline=None)
@given(image=images)
def test_brightness_equals_the_histogram_form(image: Image) -> None:
    grey = cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)
    histogram = np.bincount(grey.reshape(-1), minlength=256)
    expected = np.sqrt((histogram * np.arange(256.0) ** 2).sum() / grey.size) / 255
    assert image_reliability(image, CONFIG).brightness == pytest.approx(expected, abs=1e-12)


@settings(deadline=None)
@given(image=images, brightness_weight=st.floats(0, 1), corner_weight=st.floats(0, 1))
def test_everything_is_within_bounds_and_adds_up(image: Image, brightness_weight: float, corner_weight: float) -> None:
    config = ImageReliabilityConfig(brightness_weight=brightness_weight, corner_weight=corner_weight)
    total, brightness, corners = image_reliability(image, config)
    assert 0 <= brightness <= 1
    assert 0 <= corners <= 1
    assert total == pytest.approx(min(brightness_weight * brightness + corner_weight * corners, 1.0))


@settings(deadline=None)
@given(image=images, gain=st.floats(0, 1))
def test_a_darker_image_is_less_bright(image: Image, gain: float) -> None:
    darker = (image * gain).astype(np.uint8)
    assert image_reliability(darker, CONFIG).brightness <= image_reliability(image, CONFIG).brightness


def test_known_images() -> None:
    black, white = np.zeros((48, 64, 3), np.uint8), np.full((48, 64, 3), 255, np.uint8)
    assert image_reliability(black, CONFIG) == (0.0, 0.0, 0.0)
    assert image_reliability(white, CONFIG) == pytest.approx((0.67, 1.0, 0.0))
    rich = image_reliability(texture(), CONFIG)
    assert rich.corners == 1.0
    assert rich.image == pytest.approx(0.67 * rich.brightness + 0.33)


def test_blur_and_darkness_take_corners_away() -> None:
    image = texture()
    counts = [image_reliability(blurred(image, sigma), LITERAL).corners for sigma in (0.3, 1.5, 3.0, 6.0)]
    assert counts == sorted(counts, reverse=True)
    assert counts[0] > 10 * counts[-1]
    assert image_reliability((image * 0.05).astype(np.uint8), LITERAL).corners == 0


@settings(deadline=None, max_examples=40)
@given(seed=st.integers(0, 1000), height=st.integers(1, 90), width=st.integers(1, 90), threshold=st.integers(1, 254))
def test_corners_in_bands_are_the_corners_of_the_whole(seed: int, height: int, width: int, threshold: int) -> None:
    grey = np.random.default_rng(seed).integers(0, 256, (height, width), np.uint8)
    whole = cv2.FastFeatureDetector.create(threshold, nonmaxSuppression=True).detect(grey)
    assert count_corners(grey, threshold) == len(whole)


def test_counting_may_stop_early_but_never_changes_the_share() -> None:
    image = texture()
    grey = np.asarray(cv2.cvtColor(image, cv2.COLOR_RGB2GRAY), np.uint8)
    total = count_corners(grey, 30)
    assert 100 <= count_corners(grey, 30, enough=100.0) < total
    literal = image_reliability(image, LITERAL).corners
    assert literal == pytest.approx(total / grey.size)
    half = ImageReliabilityConfig(corner_density_saturated=2 * total / grey.size)
    assert image_reliability(image, half).corners == pytest.approx(0.5)


def test_colour_order_matters() -> None:
    red = np.zeros((10, 10, 3), np.uint8)
    red[..., 0] = 255
    assert image_reliability(red, CONFIG).brightness == pytest.approx(76 / 255)  # 0.299 of white


@pytest.mark.parametrize("shape", [(0, 0, 3), (0, 5, 3), (1, 1, 3), (3, 100, 3)])
def test_tiny_images(shape: tuple[int, int, int]) -> None:
    result = image_reliability(np.full(shape, 200, np.uint8), CONFIG)
    assert result.corners == 0
    assert (result.brightness > 0) == (0 not in shape)


@pytest.mark.parametrize(
    "bad",
    [
        {"brightness_weight": 1.2},
        {"corner_weight": -0.1},
        {"corner_density_saturated": 0.0},
        {"corner_density_saturated": 1.5},
        {"fast_threshold": 0},
        {"fast_threshold": 255},
    ],
)
def test_bad_settings_are_reported(bad: dict[str, float]) -> None:
    with pytest.raises(SettingError, match=next(iter(bad))):
        ImageReliabilityConfig(**bad)  # type: ignore[arg-type] # the fast threshold is an int


@pytest.mark.recordings
def test_real_photos_have_the_densities_that_the_default_is_chosen_from(recordings: Path) -> None:
    """The figures in `ImageReliabilityConfig.corner_density_saturated`'s docstring."""
    sharp = [
        *(recordings / "photos" / "utadl_forest").glob("*.jpg"),
        *(recordings / "photos" / "anymal_wvn").glob("*.png"),
        *(recordings / "images_labelled" / "rugd" / "images").glob("*.png"),
        *(recordings / "images_labelled" / "orfd" / "image_data").glob("*.png"),
        *(recordings / "lidar" / "rellis3d").glob("*.jpg"),
        *(recordings / "lidar" / "kitti" / "image_2").glob("*.png"),
    ]
    motion_blurred = sorted((recordings / "photos" / "motion_blur").iterdir())
    densities = sorted(_density(path) for path in sharp)
    assert len(densities) == 17
    assert [round(density, 3) for density in densities[:2]] == [0.003, 0.004]
    assert 0.009 <= densities[2] < densities[-1] < 0.0435
    assert [round(_density(path), 4) for path in motion_blurred] == [0.0002, 0.0005]


def _density(path: Path) -> float:
    bgr = cv2.imread(str(path))
    assert bgr is not None
    rgb = cv2.cvtColor(bgr, cv2.COLOR_BGR2RGB)
    return image_reliability(np.asarray(rgb, np.uint8), LITERAL).corners
