"""When, where and why a drive failed, judged from what really happened."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool

from navtool.pipeline.arrays import Array
from navtool.pipeline.geometry.transforms import quaternion_to_rpy
from navtool.sim.drive.failure import Failure, FailureKind
from navtool.sim.drive.stretches import stretches
from navtool.sim.legged.body import LEGS, STEP_S
from navtool.sim.legged.obstacle import Obstacle
from navtool.sim.legged.samples import Samples


@dataclass(kw_only=True, slots=True)
class FailureLimits:
    """From where on something counts as a failure."""

    slip_m: float = 0.08
    """Distance that a foot slides in one stance."""
    press_n: float = 25.0
    """A foot that presses less than this is free to move."""
    tilt_rad: float = 0.35
    """Roll or pitch of the body from its mean over the last seconds."""
    tilt_window_s: float = 2.0
    stuck_window_s: float = 3.0
    """It has to make no headway for this long."""
    stuck_share: float = 0.25
    """Headway below this share of what was commanded is none."""
    least_command_mps: float = 0.1
    """Commands slower than this cannot be failed."""
    held_n: float = 15.0
    """A mean drag above this holds the robot."""
    gap_s: float = 0.4
    """Failures of a kind that follow each other sooner are one."""


def find_failures(
    samples: Samples, obstacles: Sequence[Obstacle] = (), limits: FailureLimits | None = None
) -> tuple[Failure, ...]:
    """Return all failures of a drive in the order in which they began."""
    limits = limits or FailureLimits()
    if not len(samples.fallen):
        return ()
    found = [
        *_falls(samples),
        *_collisions(samples, obstacles, limits),
        *_stumbles(samples, limits),
        *_stuck(samples, obstacles, limits),
    ]
    return tuple(sorted(found, key=lambda failure: (failure.start_s, failure.kind.value)))


def _falls(samples: Samples) -> list[Failure]:
    if not samples.fallen[-1]:
        return []
    first = int(np.argmax(samples.fallen))
    reason = "the trunk lies on the ground" if samples.trunk_down[first] else "it leaned over"
    return [_failure(samples, FailureKind.fall, first, len(samples.fallen), reason)]


def _collisions(samples: Samples, obstacles: Sequence[Obstacle], limits: FailureLimits) -> list[Failure]:
    return [
        _failure(samples, FailureKind.collision, start, end, f"against {obstacles[samples.obstacle[start]].name}")
        for start, end in stretches(samples.obstacle >= 0, limits.gap_s / STEP_S)
    ]


def _stumbles(samples: Samples, limits: FailureLimits) -> list[Failure]:
    upright = ~samples.fallen
    caught = np.diff(samples.stumbles, prepend=0) > 0
    slid = _slid(samples, limits)
    thrown = _thrown(samples, limits)
    found = []
    for start, end in stretches((caught | slid.any(axis=1) | thrown) & upright, limits.gap_s / STEP_S):
        if thrown[start:end].any():
            reason = "the body was thrown about"
        elif slid[start:end].any():
            reason = f"the {LEGS[int(np.argmax(slid[start:end].any(axis=0)))]} foot slid"
        else:
            reason = "a foot was caught"
        found.append(_failure(samples, FailureKind.stumble, start, end, reason))
    return found


def _stuck(samples: Samples, obstacles: Sequence[Obstacle], limits: FailureLimits) -> list[Failure]:
    span = round(limits.stuck_window_s / STEP_S)
    if len(samples.command) <= span:
        return []
    asked = np.cumsum(np.abs(samples.command[:, 0])) * STEP_S
    asked = asked[span:] - asked[:-span]
    went = np.hypot(*(samples.position_m[span:, :2] - samples.position_m[:-span, :2]).T)
    no_headway = (asked > limits.least_command_mps * limits.stuck_window_s) & (went < limits.stuck_share * asked)
    found = []
    for first, last in stretches(no_headway & ~samples.fallen[span:], limits.gap_s / STEP_S):
        start, end = first, last + span
        touched = samples.obstacle[start:end]
        if (touched >= 0).mean() > 0.2:
            kind, reason = FailureKind.stuck, f"against {obstacles[touched.max()].name}"
        elif samples.drag_n[start:end].mean() > limits.held_n:
            kind, reason = FailureKind.entangled, "held by what grows or lies on the ground"
        else:
            kind, reason = FailureKind.stuck, "no headway"
        found.append(_failure(samples, kind, start, end, reason))
    return found


def _slid(samples: Samples, limits: FailureLimits) -> Bool[Array, "n 4"]:
    """Return when a foot that stands has slid too far since it came down."""
    foot = samples.foot_m()
    loaded = (samples.foot_force_n > limits.press_n) & samples.standing
    step = np.hypot(*np.moveaxis(np.diff(foot[..., :2], axis=0, prepend=foot[:1, :, :2]), -1, 0))
    total = np.cumsum(np.where(loaded, step, 0.0), axis=0)
    began = loaded & ~np.vstack([np.zeros((1, 4), bool), loaded[:-1]])
    # the distance slid before this stance, held from its first moment on
    before = np.maximum.accumulate(np.where(began, total - np.where(loaded, step, 0.0), 0.0), axis=0)
    return np.asarray(loaded & (total - before > limits.slip_m))


def _thrown(samples: Samples, limits: FailureLimits) -> Bool[Array, " n"]:
    """Return when the body leans far from how it has been leaning."""
    turned = quaternion_to_rpy(samples.quaternion)
    span = round(limits.tilt_window_s / STEP_S)
    total = np.cumsum(np.pad(turned[:, :2], ((span, 0), (0, 0)), mode="edge"), axis=0)
    mean = (total[span:] - total[:-span]) / span
    return np.asarray((np.abs(turned[:, :2] - mean) > limits.tilt_rad).any(axis=1))


def _failure(samples: Samples, kind: FailureKind, start: int, end: int, reason: str) -> Failure:
    x, y, _ = samples.position_m[start].tolist()
    return Failure(kind, start * STEP_S, end * STEP_S, x, y, reason)
