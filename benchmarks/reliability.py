"""Image and cloud reliability as ingest computes them: one camera frame of 640x480 and one VLP-16 sweep."""

import cv2
import numpy as np
from _report import Row, median_seconds, write_report
from numpy.typing import NDArray

from navtool.pipeline.cloud_reliability import CloudReliabilityConfig, cloud_reliability
from navtool.pipeline.image_reliability import ImageReliabilityConfig, image_reliability

BAR_MS = 3.0
RINGS, COLUMNS = 16, 1800


def main() -> None:
    """Time both; the bar is for their sum. The peer of each is the one library call it cannot do without."""
    rng = np.random.default_rng(0)
    noise = rng.integers(0, 255, (60, 80, 3), dtype=np.uint8)
    rgb = np.asarray(cv2.resize(noise, (640, 480), interpolation=cv2.INTER_CUBIC), dtype=np.uint8)
    xyz, ring = _sweep(rng)
    image, cloud = ImageReliabilityConfig(), CloudReliabilityConfig()
    image_s, gray_s = median_seconds(
        lambda: image_reliability(rgb, image), lambda: cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY), rounds=20
    )
    cloud_s, norm_s = median_seconds(
        lambda: cloud_reliability(xyz, ring, cloud), lambda: np.linalg.norm(xyz, axis=1), rounds=20
    )
    total = (image_s + cloud_s) * 1e3
    rows = [
        Row(what="image, 640x480", ours=image_s * 1e3, peer=gray_s * 1e3, ratio=image_s / gray_s, unit="ms"),
        Row(what="cloud, VLP-16", ours=cloud_s * 1e3, peer=norm_s * 1e3, ratio=cloud_s / norm_s, unit="ms"),
        Row(what="both", ours=total, unit="ms", bar=BAR_MS, holds=total <= BAR_MS),
    ]
    write_report("reliability", rows)


def _sweep(rng: np.random.Generator) -> tuple[NDArray[np.float32], NDArray[np.uint16]]:
    """A sweep over flat ground and a round wall, with range noise."""
    ring = np.tile(np.arange(RINGS, dtype=np.uint16), COLUMNS)
    elevation = np.radians(np.tile(np.linspace(-15, 15, RINGS), COLUMNS))
    azimuth = np.repeat(np.linspace(-np.pi, np.pi, COLUMNS, endpoint=False), RINGS)
    down = np.where(elevation < 0, 0.8 / np.sin(np.maximum(-elevation, 1e-3)), np.inf)
    distance = np.minimum(down, 20.0 / np.cos(elevation)) + rng.normal(0, 0.02, azimuth.size)
    flat = distance * np.cos(elevation)
    xyz = np.stack([flat * np.cos(azimuth), flat * np.sin(azimuth), distance * np.sin(elevation)], axis=1)
    return xyz.astype(np.float32), ring


if __name__ == "__main__":
    main()
