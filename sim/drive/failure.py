"""What goes wrong on a drive: when, where and why."""

from dataclasses import dataclass
from enum import StrEnum


class FailureKind(StrEnum):
    """What went wrong."""

    stumble = "stumble"
    """A foot was caught or slid away, or the body was thrown about; the robot went on."""
    fall = "fall"
    """It leaned too far, or lay on its trunk."""
    stuck = "stuck"
    """It was commanded to go and did not."""
    entangled = "entangled"
    """The same, held by what grows or lies on the ground."""
    collision = "collision"
    """The body, a wheel or a leg pushed against an obstacle."""


@dataclass(frozen=True, slots=True)
class Failure:
    """A stretch of a drive that failed."""

    kind: FailureKind
    start_s: float
    """From the drive's begin."""
    end_s: float
    x_m: float
    """Where the body was when it began, world frame."""
    y_m: float
    reason: str
    """What stopped, held or threw it, in a few words."""
