"""What the papers' mathematics costs a frame: sensor reliability, the fixed-size cloud, the trajectory image."""

import os
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from _report import Row, median_seconds, write_report
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from navtool.pipeline.cloud_reliability import CloudReliabilityConfig, cloud_reliability
from navtool.pipeline.downsample import fixed_size_cloud
from navtool.pipeline.geometry.camera import CameraModel
from navtool.pipeline.geometry.trajectory_image import TrajectoryImageConfig, trajectory_image, trajectory_images
from navtool.pipeline.geometry.transforms import transform_from_xyz_rpy
from navtool.pipeline.image_reliability import ImageReliabilityConfig, image_reliability

ROOT = Path(__file__).resolve().parents[1]
ROUNDS = 30
FRAME_BAR_MS = 3.0


def main() -> None:
    cv2.setNumThreads(1)
    rgb, source = photo()
    xyz, ring = scan()
    write_report("reliability", [*reliability_rows(rgb, source, xyz, ring), *other_rows(xyz)])


def reliability_rows(
    rgb: NDArray[np.uint8], source: str, xyz: NDArray[np.float32], ring: NDArray[np.uint16]
) -> list[Row]:
    """One frame of camera and LiDAR; the peers find every corner, and the same points' neighbours with a k-d tree."""
    image_config, cloud_config = ImageReliabilityConfig(), CloudReliabilityConfig()
    detector = cv2.FastFeatureDetector.create(image_config.fast_threshold)
    looked_at: Any = xyz[:: -(-len(xyz) // cloud_config.max_points)]
    image, corners, cloud, tree = median_seconds(
        lambda: image_reliability(rgb, image_config),
        lambda: detector.detect(cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY)),
        lambda: cloud_reliability(xyz, ring, cloud_config),
        lambda: cKDTree(xyz).query(looked_at, k=cloud_config.neighbours),
        rounds=ROUNDS,
    )
    both = 1000 * (image + cloud)
    return [
        milliseconds(f"image, 640x480 ({source}), against FAST on all of it", image, corners),
        milliseconds("cloud, 28,800 points in 16 rings, against a k-d tree", cloud, tree),
        Row(what="image and cloud, a frame", ours=both, unit="ms", bar=FRAME_BAR_MS, holds=both <= FRAME_BAR_MS),
    ]


def other_rows(xyz: NDArray[np.float32]) -> list[Row]:
    """The fixed-size cloud against NumPy's unique rows, and trajectory images one by one and fifty at once."""
    camera = CameraModel(640, 480, 400.0, 400.0, 319.5, 239.5, "plumb_bob", (-0.3, 0.09, 0.001, -0.001, 0.0))
    optical = np.array([[0.0, 0, 1, 0], [-1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 0, 1]])
    pose = transform_from_xyz_rpy(np.array([0.2, 0.0, 0.6]), np.array([0.0, 0.3, 0.0])) @ optical
    rng = np.random.default_rng(0)
    candidates = np.column_stack([rng.uniform(0, 1.5, 50), rng.uniform(-1, 1, 50)])
    config = TrajectoryImageConfig()
    downsample, unique, single, fifty = median_seconds(
        lambda: fixed_size_cloud(xyz),
        lambda: np.unique(np.floor(xyz[xyz[:, 0] >= 0] / 0.05).astype(np.int32), axis=0, return_index=True),
        lambda: trajectory_image(candidates[0], camera, pose, config),
        lambda: trajectory_images(candidates, camera, pose, config),
        rounds=ROUNDS,
    )
    return [
        milliseconds("fixed-size cloud of 28,800 points, against unique voxels", downsample, unique, bar=2.0),
        milliseconds("trajectory image, 320x240, distorted lens", single, bar=0.5),
        milliseconds("trajectory image of fifty, each, against one at a time", fifty / 50, single, bar=0.5),
    ]


def milliseconds(what: str, ours: float, peer: float | None = None, bar: float | None = None) -> Row:
    return Row(
        what=what,
        ours=1000 * ours,
        peer=None if peer is None else 1000 * peer,
        ratio=None if peer is None else peer / ours,
        unit="ms",
        bar=bar,
        holds=bar is None or 1000 * ours <= bar,
    )


def photo() -> tuple[NDArray[np.uint8], str]:
    """A real trail at 640x480 where it is there, else blurred noise with as many corners."""
    data = Path(os.environ.get("NAVTOOL_DATA", ROOT.parent / "shared" / "data"))
    path = data / "images_labelled" / "rugd" / "images" / "trail-11_02001.png"
    bgr = cv2.imread(str(path)) if path.is_file() else None
    if bgr is None:
        noise = np.random.default_rng(0).integers(0, 256, (480, 640, 3), np.uint8)
        return np.asarray(cv2.GaussianBlur(noise, (0, 0), 1.6), np.uint8), "blurred noise"
    small = cv2.resize(bgr, (640, 480), interpolation=cv2.INTER_AREA)
    return np.asarray(cv2.cvtColor(small, cv2.COLOR_BGR2RGB), np.uint8), "a trail"


def scan() -> tuple[NDArray[np.float32], NDArray[np.uint16]]:
    """A full turn of 16 rings in a rough round place, in firing order."""
    rng = np.random.default_rng(0)
    azimuth, elevation = np.meshgrid(
        np.radians(np.arange(-180, 180, 0.2)), np.radians(np.arange(-15.0, 16, 2)), indexing="ij"
    )
    distance = 6 + 3 * np.sin(3 * azimuth) + rng.normal(0, 0.02, azimuth.shape)
    level = distance * np.cos(elevation)
    points = np.stack([level * np.cos(azimuth), level * np.sin(azimuth), distance * np.sin(elevation)], axis=-1)
    return points.reshape(-1, 3).astype(np.float32), np.tile(np.arange(16, dtype=np.uint16), len(azimuth))


if __name__ == "__main__":
    main()
