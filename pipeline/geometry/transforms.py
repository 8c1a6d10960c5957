"""Rigid transforms: 4x4 matrices, quaternions (x, y, z, w), roll-pitch-yaw and interpolation.

Frames and signs follow REP-103: x forward, y left, z up, angles counter-clockwise. A matrix named `base_lidar` is the
pose of the lidar frame in base, so that `p_base = base_lidar @ p_lidar`. Every function takes any leading axes.
"""

import numpy as np
from jaxtyping import Float, Float64

from navtool.pipeline.arrays import Array

_GIMBAL_COSINE = 1e-9
_PARALLEL_SINE = 1e-9


def transform_from_xyz_rpy(
    xyz: Float[Array, "*batch 3"], rpy: Float[Array, "*batch 3"]
) -> Float64[Array, "*batch 4 4"]:
    """The transform with translation `xyz` (metres) and rotation Rz(yaw) Ry(pitch) Rx(roll) (radians)."""
    return transform_from_xyz_quaternion(xyz, quaternion_from_rpy(rpy))


def transform_from_xyz_quaternion(
    xyz: Float[Array, "*batch 3"], quaternion: Float[Array, "*batch 4"]
) -> Float64[Array, "*batch 4 4"]:
    """The transform with translation `xyz` (metres) and the rotation of a quaternion (x, y, z, w) of any length.

    Raises:
        ValueError: A quaternion is zero or not finite, as messages leave it whose orientation was never set.
    """
    x, y, z, w = np.moveaxis(_unit(quaternion), -1, 0)
    transform = np.zeros((*quaternion.shape[:-1], 4, 4))
    transform[..., 0, 0] = 1 - 2 * (y * y + z * z)
    transform[..., 0, 1] = 2 * (x * y - z * w)
    transform[..., 0, 2] = 2 * (x * z + y * w)
    transform[..., 1, 0] = 2 * (x * y + z * w)
    transform[..., 1, 1] = 1 - 2 * (x * x + z * z)
    transform[..., 1, 2] = 2 * (y * z - x * w)
    transform[..., 2, 0] = 2 * (x * z - y * w)
    transform[..., 2, 1] = 2 * (y * z + x * w)
    transform[..., 2, 2] = 1 - 2 * (x * x + y * y)
    transform[..., :3, 3] = xyz
    transform[..., 3, 3] = 1.0
    return transform


def invert_transform(transform: Float[Array, "*batch 4 4"]) -> Float64[Array, "*batch 4 4"]:
    """The inverse of a rigid transform, by transposing its rotation."""
    inverse = np.zeros(transform.shape)
    rotation = np.swapaxes(transform[..., :3, :3], -1, -2)
    inverse[..., :3, :3] = rotation
    inverse[..., :3, 3] = -(rotation @ transform[..., :3, 3:])[..., 0]
    inverse[..., 3, 3] = 1.0
    return inverse


def apply_transform(
    transform: Float[Array, "*batch 4 4"], points: Float[Array, "*batch n 3"]
) -> Float[Array, "*batch n 3"]:
    """The points in the transform's parent frame, in the points' own dtype.

    Note:
        The arithmetic is that of the points: float32 points keep about 1e-7 of their distance from either origin,
        10 micrometres at 100 m. Coordinates of millions of metres (UTM) need float64 points.
    """
    rotation = np.swapaxes(transform[..., :3, :3], -1, -2).astype(points.dtype)
    translation = transform[..., None, :3, 3].astype(points.dtype)
    moved: Array = points @ rotation + translation
    return moved


def quaternion_from_rpy(rpy: Float[Array, "*batch 3"]) -> Float64[Array, "*batch 4"]:
    """The unit quaternion (x, y, z, w) of Rz(yaw) Ry(pitch) Rx(roll); angles in radians."""
    half = np.moveaxis(rpy.astype(np.float64), -1, 0) / 2
    (cr, cp, cy), (sr, sp, sy) = np.cos(half), np.sin(half)
    return np.stack(
        [
            sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy,
            cr * cp * cy + sr * sp * sy,
        ],
        axis=-1,
    )


def quaternion_to_rpy(quaternion: Float[Array, "*batch 4"]) -> Float64[Array, "*batch 3"]:
    """Roll, pitch, yaw in radians: roll and yaw in [-pi, pi], pitch in [-pi/2, pi/2].

    Where the pitch is +-90 degrees, roll and yaw turn about the same axis: the roll is then 0.

    Raises:
        ValueError: A quaternion is zero or not finite.
    """
    return rpy_from_transform(transform_from_xyz_quaternion(np.zeros((*quaternion.shape[:-1], 3)), quaternion))


def rpy_from_transform(transform: Float[Array, "*batch 4 4"]) -> Float64[Array, "*batch 3"]:
    """Roll, pitch, yaw in radians of the transform's rotation; ranges as in `quaternion_to_rpy`."""
    m = transform.astype(np.float64)
    cosine = np.hypot(m[..., 0, 0], m[..., 1, 0])
    locked = cosine < _GIMBAL_COSINE
    roll = np.where(locked, 0.0, np.arctan2(m[..., 2, 1], m[..., 2, 2]))
    pitch = np.arctan2(-m[..., 2, 0], cosine)
    yaw = np.where(locked, np.arctan2(-m[..., 0, 1], m[..., 1, 1]), np.arctan2(m[..., 1, 0], m[..., 0, 0]))
    return np.stack([roll, pitch, yaw], axis=-1)


def yaw_from_quaternion(quaternion: Float[Array, "*batch 4"]) -> Float64[Array, "*batch"]:
    """The heading about the z axis in radians, in [-pi, pi].

    Raises:
        ValueError: A quaternion is zero or not finite.
    """
    return quaternion_to_rpy(quaternion)[..., 2]


def quaternion_from_transform(transform: Float[Array, "*batch 4 4"]) -> Float64[Array, "*batch 4"]:
    """The unit quaternion (x, y, z, w) of the transform's rotation, with w >= 0."""
    m = transform[..., :3, :3].astype(np.float64)
    trace = m[..., 0, 0] + m[..., 1, 1] + m[..., 2, 2]
    # Four times the outer product of the quaternion with itself: its longest row is never near zero.
    outer = np.empty((*m.shape[:-2], 4, 4))
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        outer[..., i, i] = 1 + 2 * m[..., i, i] - trace
        outer[..., i, j] = outer[..., j, i] = m[..., i, j] + m[..., j, i]
        outer[..., i, 3] = outer[..., 3, i] = m[..., k, j] - m[..., j, k]
    outer[..., 3, 3] = 1 + trace
    longest = np.argmax(np.diagonal(outer, axis1=-2, axis2=-1), axis=-1)
    quaternion = np.take_along_axis(outer, longest[..., None, None], axis=-2)[..., 0, :]
    quaternion = quaternion / np.linalg.norm(quaternion, axis=-1, keepdims=True)
    return np.where(quaternion[..., 3:] < 0, -quaternion, quaternion)


def slerp(
    first: Float[Array, "*batch 4"], second: Float[Array, "*batch 4"], fraction: Float[Array, "*batch"]
) -> Float64[Array, "*batch 4"]:
    """The rotation at `fraction` (0 gives `first`, 1 gives `second`) of the shorter way between two quaternions.

    Raises:
        ValueError: A quaternion is zero or not finite.
    """
    start, end = _unit(first), _unit(second)
    cosine = np.sum(start * end, axis=-1)
    end = np.where(cosine[..., None] < 0, -end, end)
    # From the half-angle chord: exact for tiny angles, where arccos of the product is not.
    angle = 2 * np.arctan2(np.linalg.norm(end - start, axis=-1), np.linalg.norm(end + start, axis=-1))
    sine = np.sin(angle)
    near = sine < _PARALLEL_SINE
    safe = np.where(near, 1.0, sine)
    weight_start = np.where(near, 1 - fraction, np.sin((1 - fraction) * angle) / safe)
    weight_end = np.where(near, fraction, np.sin(fraction * angle) / safe)
    return _unit(weight_start[..., None] * start + weight_end[..., None] * end)


def wrap_angle(angle_rad: Float[Array, "*batch"]) -> Float64[Array, "*batch"]:
    """The same angle in [-pi, pi)."""
    return np.mod(angle_rad.astype(np.float64) + np.pi, 2 * np.pi) - np.pi


def _unit(quaternion: Float[Array, "*batch 4"]) -> Float64[Array, "*batch 4"]:
    wide = quaternion.astype(np.float64)
    norm = np.linalg.norm(wide, axis=-1, keepdims=True)
    bad = int(np.count_nonzero(~(np.isfinite(norm) & (norm > 0))))
    if bad:
        what = f"{bad} of {norm.size} quaternions are zero or not finite"
        raise ValueError(f"{what}: no rotation; drop the samples whose orientation was never set")
    unit: Array = wide / norm
    return unit
