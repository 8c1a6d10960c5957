"""A wall seen from a moving robot is straight again once the motion is taken out."""

import numpy as np
import pytest
from numpy.typing import NDArray

from navtool.pipeline.geometry.deskew import deskewed
from navtool.pipeline.geometry.transforms import invert_transform, transform_from_xyz_rpy


@pytest.mark.parametrize("from_s", [-0.1, 0.0])
def test_static_points_return_to_where_they_were_at_the_stamp(from_s: float) -> None:
    rng = np.random.default_rng(0)
    time_s = np.sort(rng.uniform(from_s, from_s + 0.1, 5000)).astype(np.float32)
    still = rng.uniform(-30, 30, (5000, 3))

    def pose(at_s: NDArray[np.float64]) -> NDArray[np.float64]:
        speed, turn = 2.0, 1.5
        zero = np.zeros_like(at_s)
        xyz = np.stack([speed / turn * np.sin(turn * at_s), speed / turn * (1 - np.cos(turn * at_s)), zero], axis=-1)
        return transform_from_xyz_rpy(xyz, np.stack([zero, 0.2 * at_s, turn * at_s], axis=-1))

    seen = np.einsum("nij,nj->ni", invert_transform(pose(time_s.astype(float))), np.c_[still, np.ones(5000)])[:, :3]
    knots = np.linspace(from_s, from_s + 0.1, 17)
    straight = deskewed(np.ascontiguousarray(seen.T, np.float32), time_s, knots, pose(np.asarray(knots, np.float64)))
    assert np.abs(seen - still).max() > 1.0
    assert np.abs(straight.T - still).max() < 0.002
