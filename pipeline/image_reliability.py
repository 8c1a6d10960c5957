"""How far a camera image can be trusted: its brightness and its corners (GrASPE, eq. 1-2)."""

from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import cv2
import numpy as np
from jaxtyping import UInt8

from navtool.base.setting_checks import outside
from navtool.base.setting_error import refuse
from navtool.pipeline.arrays import Array

_BANDS = 8
_FAST_REACH_PX = 3
_BAND_OVERLAP_PX = _FAST_REACH_PX + 1


@dataclass(kw_only=True, slots=True)
class ImageReliabilityConfig:
    """Weights and scales of the image reliability."""

    brightness_weight: float = 0.67
    """alpha_b, the weight of the brightness, in [0, 1]; the paper's Table V."""
    corner_weight: float = 0.33
    """alpha_c, the weight of the corners, in [0, 1]; the paper's Table V."""
    corner_density_saturated: float = 0.009
    """Corners per pixel from which on an image is rich in features, in (0, 1]; 1.0 is the paper's literal formula.

    The default lies between real photos at their native resolution, counted with the default FAST threshold: of 17
    sharp outdoor ones (forest, trails, creek, parks, dirt road, street) 15 have 0.009 to 0.043 and the two plainest, a
    lawn and an empty street, 0.003 and 0.004; two with strong motion blur have 0.0002 and 0.0005.
    """
    fast_threshold: int = 30
    """Least grey level difference between a corner and the circle around it, in [1, 254].

    On the photos above, motion blur leaves 2 to 6 % of the saturated density at 30, but 6 to 13 % at 20; 30 is also
    faster.
    """

    def __post_init__(self) -> None:
        refuse(
            outside(self, 0, 1, "brightness_weight", "corner_weight"),
            outside(self, 0, 1, "corner_density_saturated", unit="corners per pixel", above=True),
            outside(self, 1, 254, "fast_threshold", unit="grey levels"),
        )


class ImageReliability(NamedTuple):
    """The reliability of an image and what it is made of, each in [0, 1]."""

    image: float
    """r_img, the weighted sum."""
    brightness: float
    """r_bright, the root mean square grey value; 1 is white."""
    corners: float
    """r_corners, 1 where the image is rich in features."""


def image_reliability(rgb: UInt8[Array, "h w 3"], config: ImageReliabilityConfig) -> ImageReliability:
    r"""The reliability of an RGB image, best at the camera's native resolution (resizing hides blur).

    .. math::
        r_{bright} = \frac{1}{255} \sqrt{\frac{1}{n} \sum_b hist(b) \, b^2}, \quad
        r_{corners} = \min(n_c / n_{sat}, 1), \quad
        r_{img} = \alpha_b r_{bright} + \alpha_c r_{corners}

    with n = w h pixels, n_c corners and n_sat = `corner_density_saturated` n. Grey is ITU-R BT.601 luma, rounded to
    whole levels; corners are FAST-9 of 16 after non-maximum suppression, as OpenCV finds them. The result is clipped to
    [0, 1], does not depend on the machine, and is 0 for an image without pixels.

    Reference: GrASPE, eq. (1) and (2).

    Note:
        The paper's RMS of the histogram's counts would not measure brightness; this is the RMS of the pixels, which the
        histogram determines. The paper divides n_c by w h, which stays below 0.05 on real photos: n_sat scales it to
        "feature rich if n_c is above a threshold".
    """
    if rgb.size == 0:
        return ImageReliability(0.0, 0.0, 0.0)
    gray = np.asarray(cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY), np.uint8)
    brightness = min(cv2.norm(gray, cv2.NORM_L2) / (255 * np.sqrt(gray.size)), 1.0)  # eq. (1)
    saturated = config.corner_density_saturated * gray.size
    corners = min(count_corners(gray, config.fast_threshold, enough=saturated) / saturated, 1.0)
    image = config.brightness_weight * brightness + config.corner_weight * corners  # eq. (2)
    return ImageReliability(float(min(image, 1.0)), float(brightness), float(corners))


def count_corners(gray: UInt8[Array, "h w"], threshold: int, *, enough: float = np.inf) -> int:
    """The number of FAST corners after non-maximum suppression; once it reaches `enough`, counting may stop there.

    The image is searched in bands that overlap as far as FAST and its suppression reach, so that the sum over them
    equals the count over the whole image.
    """
    detector = cv2.FastFeatureDetector.create(threshold, True)  # noqa: FBT003 - OpenCV's signature
    height = gray.shape[0]
    edges = np.linspace(0, height, _BANDS + 1).astype(int).tolist()
    total = 0
    for top, bottom in pairwise(edges):
        first, last = max(top - _BAND_OVERLAP_PX, 0), min(bottom + _BAND_OVERLAP_PX, height)
        mask = np.zeros((last - first, gray.shape[1]), np.uint8)
        mask[top - first : bottom - first] = 255
        total += len(detector.detect(gray[first:last], mask))
        if total >= enough:
            break
    return total
