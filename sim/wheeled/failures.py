"""When, where and why a drive of the wheeled robot failed, judged from what really happened."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool

from navtool.base.setting_checks import outside
from navtool.base.setting_error import refuse
from navtool.pipeline.arrays import Array
from navtool.sim.drive.failure import Failure, FailureKind
from navtool.sim.drive.stretches import stretches
from navtool.sim.wheeled.config import STEP_S
from navtool.sim.wheeled.samples import Samples
from navtool.sim.world.obstacle import Obstacle
from navtool.sim.world.surfaces import SURFACES


@dataclass(kw_only=True, slots=True)
class FailureLimits:
    """From where on something counts as a failure; all above 0."""

    command_mps: float = 0.1
    """Slower commands cannot be failed."""
    command_radps: float = 0.15
    """Slower turns cannot be failed."""
    headway: float = 0.25
    """Motion below this share of what is asked for is none, 0-1."""
    stuck_s: float = 1.5
    """It makes no headway for this long; starting to move takes less."""
    leaves_mps: float = 0.05
    """A collision is over when it moves this fast without pushing,"""
    leaves_radps: float = 0.15
    """or turns this fast."""
    thrown_rad: float = 0.2
    """Roll or pitch from its mean over the last seconds. Grass at full speed tilts it by 0.11, a rock bed by 0.29."""
    thrown_mps2: float = 12.0
    """Vertical acceleration of the body. Grass at full speed throws it up with 9 m/s2, a rock bed with 14 m/s2."""
    mean_s: float = 2.0
    """Over which the mean of roll and pitch is taken."""
    gap_s: float = 0.5
    """Stumbles and contacts that follow each other sooner are one."""

    def __post_init__(self) -> None:
        refuse(outside(self, 0, math.inf, *self.__slots__, above=True))


def find_failures(
    samples: Samples, obstacles: Sequence[Obstacle], limits: FailureLimits | None = None
) -> tuple[Failure, ...]:
    """All failures of a drive in the order in which they began."""
    limits = limits or FailureLimits()
    found = [
        *_falls(samples),
        *_collisions(samples, obstacles, limits),
        *_stuck(samples, obstacles, limits),
        *_stumbles(samples, limits),
    ]
    return tuple(sorted(found, key=lambda failure: (failure.start_s, failure.kind.value)))


def _falls(samples: Samples) -> list[Failure]:
    if not samples.fallen[-1]:
        return []
    first = int(np.argmax(samples.fallen))
    roll, pitch, _ = samples.rpy_rad[first]
    reason = "it tipped over sideways" if abs(roll) > abs(pitch) else "it tipped over lengthwise"
    return [_failure(samples, FailureKind.fall, first, len(samples), reason)]


def _collisions(samples: Samples, obstacles: Sequence[Obstacle], limits: FailureLimits) -> list[Failure]:
    """From the first contact until it moves without pushing."""
    moves = (np.abs(samples.speed_mps) > limits.leaves_mps) | (np.abs(samples.turn_radps) > limits.leaves_radps)
    moves &= samples.obstacle < 0
    found: list[Failure] = []
    end = 0
    for start, last in stretches(samples.obstacle >= 0, limits.gap_s / STEP_S):
        if start < end:
            continue
        leaves = np.flatnonzero(moves[last:])
        end = last + int(leaves[0]) if leaves.size else len(samples)
        reason = f"against {_named(obstacles[samples.obstacle[start]])}"
        found.append(_failure(samples, FailureKind.collision, start, end, reason))
    return found


def _stuck(samples: Samples, obstacles: Sequence[Obstacle], limits: FailureLimits) -> list[Failure]:
    speed, turn = np.abs(samples.command.T)
    # which way it goes counts: a robot that rolls back down makes no headway
    ahead, around = np.sign(samples.command).T * (samples.speed_mps, samples.turn_radps)
    goes = (speed > limits.command_mps) & (ahead > limits.headway * speed)
    goes |= (turn > limits.command_radps) & (around > limits.headway * turn)
    asked = (speed > limits.command_mps) | (turn > limits.command_radps)
    found = []
    for start, end in stretches(asked & ~goes & ~samples.fallen):
        if (end - start) * STEP_S < limits.stuck_s:
            continue
        touched = samples.obstacle[start:end]
        ground = SURFACES[int(np.bincount(samples.surface[start:end]).argmax())].name.replace("_", " ")
        kind = FailureKind.stuck
        if (touched >= 0).mean() > 0.2:
            reason = f"against {_named(obstacles[int(np.bincount(touched[touched >= 0]).argmax())])}"
        elif samples.held[start:end].mean() > 0.5:
            kind = FailureKind.entangled
            reason = "held by mud" if ground == "mud" else f"held by what grows on the {ground}"
        elif samples.spins[start:end].mean() > 0.5:
            reason = f"the wheels slip on {ground}"
        else:
            reason = f"the drives cannot climb the {ground}"
        found.append(_failure(samples, kind, start, end, reason))
    return found


def _stumbles(samples: Samples, limits: FailureLimits) -> list[Failure]:
    """Where the ground throws the body about; what a blow against an obstacle does to it is part of the collision."""
    window = round(limits.gap_s / STEP_S)
    blow = np.convolve(samples.obstacle >= 0, np.ones(window))[: len(samples)] > 0.5
    lifted = np.abs(np.diff(samples.bounce[:, 0], prepend=0.0)) / STEP_S > limits.thrown_mps2
    leans = _leans(samples, limits)
    found = []
    for start, end in stretches((lifted | leans) & ~blow & ~samples.fallen, limits.gap_s / STEP_S):
        ground = SURFACES[int(samples.surface[start])].name.replace("_", " ")
        reason = f"leaned over on {ground}" if leans[start:end].any() else f"thrown up by {ground}"
        found.append(_failure(samples, FailureKind.stumble, start, end, reason))
    return found


def _leans(samples: Samples, limits: FailureLimits) -> Bool[Array, " n"]:
    """When the body is far from how it has been leaning."""
    lean = samples.rpy_rad[:, :2]
    span = round(limits.mean_s / STEP_S)
    total = np.cumsum(np.pad(lean, ((span, 0), (0, 0)), mode="edge"), axis=0)
    mean = (total[span:] - total[:-span]) / span
    return np.asarray((np.abs(lean - mean) > limits.thrown_rad).any(axis=1))


def _named(obstacle: Obstacle) -> str:
    """Its kind in words."""
    return obstacle.kind.replace("_", " ")


def _failure(samples: Samples, kind: FailureKind, start: int, end: int, reason: str) -> Failure:
    x, y, _ = samples.ground_m[start].tolist()
    return Failure(kind, start * STEP_S, min(end, len(samples) - 1) * STEP_S, x, y, reason)
