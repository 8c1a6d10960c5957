"""Runs of moments at which something holds."""

import numpy as np
from jaxtyping import Bool

from navtool.pipeline.arrays import Array


def stretches(flags: Bool[Array, " n"], gap: float = 0.0) -> list[tuple[int, int]]:
    """First and one past last index of each run of true; runs with fewer than ``gap`` others between them are one."""
    edges = np.diff(flags.astype(np.int8), prepend=0, append=0)
    runs: list[tuple[int, int]] = []
    for start, end in zip(np.flatnonzero(edges > 0).tolist(), np.flatnonzero(edges < 0).tolist(), strict=True):
        if runs and start - runs[-1][1] < gap:
            runs[-1] = (runs[-1][0], end)
        else:
            runs.append((start, end))
    return runs
