"""Blur from the camera's own motion while its shutter is open."""

import cv2
import numpy as np
from jaxtyping import Float, Float32

from navtool.pipeline.arrays import Array
from navtool.pipeline.geometry.camera import CameraModel
from navtool.pipeline.geometry.transforms import apply_transform, invert_transform

_GRID_PX = 8
_SHARP_PX = 0.2
_FAR_M = 1000.0
"""Depth of the sky: far enough not to move with the camera's position."""


def blurred(
    picture: Float32[Array, "h w 3"],
    depth_m: Float32[Array, "h w"],
    rays: Float[Array, "h w 3"],
    model: CameraModel,
    middle_pose: Float[Array, "4 4"],
    poses: Float[Array, "k 4 4"],
) -> Float32[Array, "h w 3"]:
    """The mean of what a camera sees from several poses, made from what it sees from one between them.

    Each pixel is moved as its depth says, turning and shaking included; what lies hidden in the one picture stays
    hidden. The motion is computed every few pixels and is linear between them. A motion below a fifth of a pixel is
    none.

    Args:
        picture: What is seen from the middle pose.
        depth_m: Its depth along the optical axis; infinite for the sky.
        rays: Its viewing rays (x, y, 1), optical frame; NaN where the lens sees nothing.
        model: The camera.
        middle_pose: The pose that the picture is seen from; optical frame in the world.
        poses: The poses during the exposure.
    """
    rows, columns = (np.linspace(0, size - 1, -(-size // _GRID_PX) + 1).round().astype(int) for size in depth_m.shape)
    coarse = np.ix_(rows, columns)
    near = np.minimum(depth_m[coarse], _FAR_M).astype(np.float64)
    points = (rays[coarse] * near[..., None]).reshape(-1, 3)
    known = np.isfinite(points).all(axis=1)
    relative = invert_transform(poses) @ middle_pose
    moved = apply_transform(
        relative, np.broadcast_to(np.where(known[:, None], points, 1.0), (len(poses), *points.shape))
    )
    found = model.project(moved.reshape(-1, 3).astype(np.float64))
    start = np.stack(np.meshgrid(columns, rows), axis=-1).reshape(-1, 2)
    shift = found.pixels.reshape(len(poses), -1, 2) - start
    shift = np.where(known[:, None] & np.isfinite(shift), shift, 0.0).astype(np.float32)
    if np.abs(shift).max() < _SHARP_PX:
        return picture
    height, width = depth_m.shape
    fine_u, fine_v = np.meshgrid(np.arange(width, dtype=np.float32), np.arange(height, dtype=np.float32))
    total = np.zeros_like(picture)
    grid_u = fine_u * np.float32((len(columns) - 1) / max(width - 1, 1))
    grid_v = fine_v * np.float32((len(rows) - 1) / max(height - 1, 1))
    for displacement in shift.reshape(len(poses), len(rows), len(columns), 2):
        full = cv2.remap(displacement, grid_u, grid_v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        total += cv2.remap(
            picture, fine_u - full[..., 0], fine_v - full[..., 1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
        )
    return np.asarray(total / np.float32(len(poses)))
