"""Clipping many convex polygons at once.

A polygon is a row of corners in order around it; the results are padded to equal length by repeating corners, which
changes neither the area nor the outline.
"""

import numpy as np
from jaxtyping import Bool, Float64

from navtool.pipeline.arrays import Array

_ARC_SHARES = np.arange(1, 8) / 8


def clip_to_half_space(
    polygons: Float64[Array, "n corners dim"], normal: Float64[Array, " dim"], offset: float
) -> tuple[Float64[Array, "kept more dim"], Bool[Array, " n"]]:
    """The parts of convex polygons where normal . point >= offset, and the mask of those with a part left.

    Reference: Sutherland and Hodgman, "Reentrant polygon clipping", 1974; all polygons advance together.
    """
    distance = polygons @ normal - offset
    inside = distance >= 0
    kept = np.asarray(inside.any(axis=1))
    if inside.all():
        return polygons, kept
    polygons, distance, inside = polygons[kept], distance[kept], inside[kept]
    after = np.roll(distance, -1, axis=1)
    crosses = inside != (after >= 0)
    fraction = distance / np.where(crosses, distance - after, 1.0)
    cuts = polygons + fraction[..., None] * (np.roll(polygons, -1, axis=1) - polygons)
    return _compact(polygons, inside, cuts, crosses), kept


def clip_to_disc(
    polygons: Float64[Array, "n corners 2"], radius: float
) -> tuple[Float64[Array, "kept more 2"], Bool[Array, " n"]]:
    """The parts of convex polygons within a disc about the origin, and the mask of those with a part left.

    Note:
        Where the outline follows the circle, eight chords replace the arc. A polygon none of whose edges enters the
        disc is left out even if it contains the disc.
    """
    inside = np.hypot(polygons[..., 0], polygons[..., 1]) <= radius
    if inside.all():
        return polygons, np.ones(len(polygons), np.bool_)
    edge = np.roll(polygons, -1, axis=1) - polygons
    # |p + t e| = radius: a t^2 + 2 b t + c = 0.
    a = np.maximum(np.sum(edge * edge, axis=-1), 1e-300)
    b = np.sum(polygons * edge, axis=-1)
    c = np.sum(polygons * polygons, axis=-1) - radius * radius
    discriminant = b * b - a * c
    root = np.sqrt(np.maximum(discriminant, 0.0))
    enter, leave = np.maximum((-b - root) / a, 0.0), np.minimum((-b + root) / a, 1.0)
    touches = (discriminant >= 0) & (enter <= leave)
    kept = touches.any(axis=1)
    first = polygons + np.clip(enter, 0.0, 1.0)[..., None] * edge
    second = polygons + np.clip(leave, 0.0, 1.0)[..., None] * edge
    after = np.roll(polygons, -1, axis=1)
    turns_left = (polygons[..., 0] * after[..., 1] - after[..., 0] * polygons[..., 1]).sum(axis=1) > 0
    chords = _compact(first[kept], touches[kept], second[kept], touches[kept])
    return _with_arcs(chords, turns_left[kept], radius), kept


def _with_arcs(
    chords: Float64[Array, "n ends 2"], turns_left: Bool[Array, " n"], radius: float
) -> Float64[Array, "n more 2"]:
    """The outlines with points on the arc from each chord's end to the next one's start, where both are on the circle.

    The padding repeats an end, and from a point to itself the arc has no length.
    """
    starts, ends = chords[:, 0::2], chords[:, 1::2]
    following = np.roll(starts, -1, axis=1)
    rim = 0.999999 * radius
    on_circle = (np.hypot(ends[..., 0], ends[..., 1]) > rim) & (np.hypot(following[..., 0], following[..., 1]) > rim)
    leaving, coming = np.arctan2(ends[..., 1], ends[..., 0]), np.arctan2(following[..., 1], following[..., 0])
    # The arc turns the way the outline does, the long way round where it must; a full turn is rounding of none.
    sense = np.where(turns_left, 1.0, -1.0)[:, None]
    turn = np.mod(sense * (coming - leaving), 2 * np.pi)
    on_circle &= turn < 2 * np.pi - 1e-6
    angle = leaving[..., None] + (sense * turn)[..., None] * _ARC_SHARES
    arcs = radius * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    arcs = np.where(on_circle[:, :, None, None], arcs, ends[:, :, None])
    outline = np.concatenate([starts[:, :, None], ends[:, :, None], arcs], axis=2)
    return np.asarray(outline.reshape(len(chords), outline.shape[1] * outline.shape[2], 2))


def _compact(
    first: Float64[Array, "n corners dim"],
    first_valid: Bool[Array, "n corners"],
    second: Float64[Array, "n corners dim"],
    second_valid: Bool[Array, "n corners"],
) -> Float64[Array, "n most dim"]:
    """The valid ones of first[0], second[0], first[1], ... of each row, the last of them repeated to equal length."""
    n, corners, dim = first.shape
    points = np.stack([first, second], axis=2).reshape(n, 2 * corners, dim)
    valid = np.stack([first_valid, second_valid], axis=2).reshape(n, 2 * corners)
    count = valid.sum(axis=1)
    order = np.argsort(~valid, axis=1, kind="stable")
    corner = np.minimum(np.arange(int(count.max(initial=0))), count[:, None] - 1)
    return np.take_along_axis(points, np.take_along_axis(order, corner, axis=1)[..., None], axis=1)
