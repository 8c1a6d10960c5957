"""Which steps of E_t are known: those at which the driven path still follows the predicted one."""

import numpy as np
from jaxtyping import Bool, Float, Float64, Int64

from navtool.pipeline.arrays import Array
from navtool.pipeline.geometry.unicycle import rollout


def known_steps(
    pose: Float[Array, "rows 3"],
    state: Float[Array, "rows 2"],
    valid: Bool[Array, " rows"],
    fps: int,
    horizon: int,
    max_deviation_m: float,
    outcome: Int64[Array, " rows"] | None = None,
) -> Bool[Array, "rows {horizon}"]:
    r"""Whether the outcome at row t + k is that of the trajectory predicted at row t, for k = 0 .. horizon - 1.

    E_t[k] is the outcome at row t + k, k / fps seconds after row t; k = 0 is row t itself. The predicted trajectory
    keeps row t's measured :math:`(v, \omega)`. Step k is known as long as the driven positions of the rows up to
    t + k lie within ``max_deviation_m`` of the predicted ones, all of them are valid and in the episode: once the
    robot has left the predicted trajectory, nothing later is known of it, even where the two cross again.

    A failure ends that comparison: a robot that has collided does not follow its prediction any further, and the
    predicted trajectory does not pass either. Steps from a known failed one on stay known while the outcome stays 0.

    Args:
        pose: [x_m, y_m, yaw_rad] of each row in a fixed frame.
        state: [v_mps, omega_radps] of each row.
        valid: Whether pose and state were measured.
        fps: Rows per second.
        horizon: T, at least 1.
        max_deviation_m: Largest distance between driven and predicted position.
        outcome: 1 or 0 per row; None where failures are not known yet.

    Reference: GrASPE, IV-E: labels of trajectories; decision G11 in ``docs/papers.md``.
    """
    rows = len(pose)
    ahead = np.arange(rows)[:, None] + np.arange(horizon)
    inside = ahead < rows
    at = ahead.clip(max=rows - 1)
    reached = np.logical_and.accumulate(inside & valid[at], axis=1)
    follows = reached & (_deviations(pose, state, at, fps) <= max_deviation_m)
    known = np.logical_and.accumulate(follows, axis=1)
    if outcome is None:
        return known
    failed = outcome[at] == 0
    for step in range(1, horizon):
        known[:, step] |= known[:, step - 1] & failed[:, step - 1] & failed[:, step] & reached[:, step]
    return known


def _deviations(
    pose: Float[Array, "rows 3"], state: Float[Array, "rows 2"], at: Int64[Array, "rows steps"], fps: int
) -> Float64[Array, "rows steps"]:
    """Distance in metres between the driven and the predicted position at each step; 0 at the row itself."""
    horizon = at.shape[1]
    if horizon == 1:
        return np.zeros(at.shape)
    wide = pose.astype(np.float64)
    offset = wide[at[:, 1:], :2] - wide[:, None, :2]
    cosine, sine = np.cos(wide[:, 2, None]), np.sin(wide[:, 2, None])
    driven_x = cosine * offset[..., 0] + sine * offset[..., 1]
    driven_y = -sine * offset[..., 0] + cosine * offset[..., 1]
    predicted = rollout(state, horizon - 1, 1.0 / fps)
    return np.hstack([np.zeros((len(pose), 1)), np.hypot(driven_x - predicted[..., 0], driven_y - predicted[..., 1])])
