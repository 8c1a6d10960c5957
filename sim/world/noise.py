"""Smooth noise on a grid."""

import cv2
import numpy as np
from jaxtyping import Float32

from navtool.pipeline.arrays import Array


def smooth_noise(rng: np.random.Generator, side: int, feature: float) -> Float32[Array, "side side"]:
    """Noise of zero mean and unit deviation whose features are ``feature`` samples wide, at least 2.

    Guarantee: equal generators give equal noise.
    """
    cells = max(2, int(np.ceil(side / feature)))
    grid = rng.standard_normal((cells + 4, cells + 4), dtype=np.float32)
    axis = (np.arange(side, dtype=np.float32) + np.float32(0.5)) * np.float32(cells / side) + np.float32(1.5)
    columns, rows = np.meshgrid(axis, axis)
    noise = cv2.remap(grid, columns, rows, cv2.INTER_CUBIC)
    return np.asarray((noise - noise.mean()) / max(float(noise.std()), 1e-9), np.float32)
