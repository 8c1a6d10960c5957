"""Rules that find failed portions of a run in its own signals. Pure: arrays in, intervals out."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Float64, Int64
from scipy.ndimage import median_filter

from navtool.datasets.labels.config import (
    CollisionConfig,
    FallConfig,
    InterventionConfig,
    LabelConfig,
    StuckConfig,
)
from navtool.datasets.labels.intervals import FAILURE, LabelInterval, runs
from navtool.pipeline.arrays import Array

_CHI3_MEDIAN = 1.5382
"""Median length of a vector of three standard normal values: turns a median magnitude into a deviation an axis."""
_STILL_MPS2 = 1e-9
_PLANAR_RAD = 1e-6


@dataclass(frozen=True, slots=True)
class ImuSignal:
    """Accelerations at the IMU's own rate, stamps increasing."""

    stamps_ns: Int64[Array, " samples"]
    acceleration: Float[Array, "samples 3"]
    """m/s2, gravity included, on whatever axis it is."""


@dataclass(frozen=True, slots=True)
class FlagSignal:
    """A flag's messages, stamps increasing; each holds until the next."""

    stamps_ns: Int64[Array, " messages"]
    active: Bool[Array, " messages"]


@dataclass(frozen=True, slots=True)
class Signals:
    """What the rules look at: the rows of an episode, and its native streams where it has them."""

    stamps_ns: Int64[Array, " rows"]
    state: Float[Array, "rows 2"]
    """[v_mps, omega_radps] as measured."""
    action: Float[Array, "rows 2"]
    """[v_mps, omega_radps] as commanded."""
    pose: Float[Array, "rows 6"]
    """x, y, z in metres, roll, pitch, yaw in radians."""
    state_valid: Bool[Array, " rows"]
    """Whether state and pose were measured."""
    action_valid: Bool[Array, " rows"]
    period_ns: int
    imu: ImuSignal | None = None
    intervention: FlagSignal | None = None


@dataclass(frozen=True, slots=True)
class RuleResult:
    """What one rule says of one episode."""

    rule: str
    intervals: tuple[LabelInterval, ...] = ()
    not_applicable: str | None = None
    """Why the rule could say nothing; None where it was applied."""


def apply_rules(signals: Signals, config: LabelConfig) -> tuple[RuleResult, ...]:
    """Every rule's result, whether it applies or not, in a fixed order."""
    return (
        collision(signals, config.collision),
        stuck(signals, config.stuck),
        fall(signals, config.fall),
        intervention(signals, config.intervention),
    )


def collision(signals: Signals, config: CollisionConfig) -> RuleResult:
    """Portions that begin with an acceleration spike at which the robot stops.

    The spike is what a running median leaves of the acceleration vector: gravity drops out on whatever axis it is,
    and so do slopes and slow manoeuvres.
    """
    reason = _why_not(
        (not config.enabled, "switched off"),
        (signals.imu is None or signals.imu.stamps_ns.size < 2, "no imu"),
        (not signals.state_valid.any(), "no odometry"),
    )
    if reason or signals.imu is None:
        return RuleResult("collision", not_applicable=reason)
    residual = without_gravity(signals.imu, config.baseline_s)
    if not (residual > _STILL_MPS2).any():
        return RuleResult("collision", not_applicable="the imu reads a constant")
    vibration = float(np.median(residual)) / _CHI3_MEDIAN
    spikes = signals.imu.stamps_ns[residual > max(config.spike_mps2, config.spike_sigmas * vibration)]
    stamps = signals.stamps_ns[signals.state_valid]
    speed = np.abs(signals.state[signals.state_valid, 0])
    window_ns = round(config.stop_within_s * 1e9)
    intervals: list[LabelInterval] = []
    for spike in spikes.tolist():
        if intervals and spike < intervals[-1].end_ns:
            continue
        before, at, after = np.searchsorted(stamps, [spike - window_ns, spike, spike + window_ns], side="right")
        stops = np.flatnonzero(speed[at:after] < config.speed_after_mps)
        if stops.size == 0 or not (speed[before:at] > config.speed_before_mps).any():
            continue
        stop = int(at + stops[0])
        end_ns = int(stamps[stop]) + round(config.after_s * 1e9)
        drives = np.flatnonzero(speed[stop:] > config.speed_before_mps)
        if drives.size:
            end_ns = min(end_ns, int(stamps[stop + drives[0]]))
        intervals.append(LabelInterval(spike, end_ns, FAILURE, "collision", config.confidence))
    return RuleResult("collision", tuple(intervals))


def stuck(signals: Signals, config: StuckConfig) -> RuleResult:
    """Portions in which motion is commanded and none is measured; a row without command or odometry ends one."""
    reason = _why_not(
        (not config.enabled, "switched off"),
        (not signals.action_valid.any(), "no commands"),
        (not signals.state_valid.any(), "no odometry"),
    )
    if reason:
        return RuleResult("stuck", not_applicable=reason)
    command, motion = np.abs(signals.action), np.abs(signals.state)
    asked = (command > [config.command_mps, config.command_radps]).any(axis=1) & signals.action_valid
    stands = (motion < [config.moved_mps, config.moved_radps]).all(axis=1) & signals.state_valid
    return RuleResult("stuck", _lasting(signals, asked & stands, config.at_least_s, "stuck", config.confidence))


def fall(signals: Signals, config: FallConfig) -> RuleResult:
    """Portions in which the robot lies: by the odometry's roll and pitch, or by gravity where the odometry is planar.

    Gravity's direction is compared with its median over the episode, so the IMU may be mounted in any way.
    """
    planar = not (np.abs(signals.pose[signals.state_valid, 3:5]) > _PLANAR_RAD).any()
    no_imu = signals.imu is None or signals.imu.stamps_ns.size < 2
    missing = "no odometry and no imu" if not signals.state_valid.any() else "planar odometry and no imu"
    reason = _why_not((not config.enabled, "switched off"), (planar and no_imu, missing))
    if reason:
        return RuleResult("fall", not_applicable=reason)
    if planar and signals.imu is not None:
        tilt = _tilt_of_gravity(signals.imu, config.gravity_s)
        if tilt is None:
            return RuleResult("fall", not_applicable="planar odometry, and the imu measures no gravity")
        at = np.searchsorted(signals.imu.stamps_ns, signals.stamps_ns).clip(max=tilt.size - 1)
        near = np.abs(signals.imu.stamps_ns[at] - signals.stamps_ns) <= 2 * signals.period_ns
        lies = (tilt[at] > config.tilt_rad) & near
    else:
        lies = (np.abs(signals.pose[:, 3:5]) > config.tilt_rad).any(axis=1) & signals.state_valid
    return RuleResult("fall", _lasting(signals, lies, config.at_least_s, "fall", config.confidence))


def intervention(signals: Signals, config: InterventionConfig) -> RuleResult:
    """Portions in which the operator's flag is set; a flag that is still set at the end lasts to the last row."""
    flag = signals.intervention
    reason = _why_not(
        (not config.enabled, "switched off"),
        (flag is None or flag.stamps_ns.size == 0, "no intervention stream"),
    )
    if reason or flag is None:
        return RuleResult("intervention", not_applicable=reason)
    past_the_end = int(signals.stamps_ns[-1]) + signals.period_ns
    ends = np.append(flag.stamps_ns[1:], max(past_the_end, int(flag.stamps_ns[-1])))
    intervals = tuple(
        LabelInterval(int(flag.stamps_ns[first]), int(ends[stop - 1]), FAILURE, "intervention", config.confidence)
        for first, stop in runs(flag.active)
    )
    return RuleResult("intervention", intervals)


def without_gravity(imu: ImuSignal, window_s: float) -> Float64[Array, " samples"]:
    """Magnitude in m/s2 of the acceleration beside its running median over the window."""
    wide = imu.acceleration.astype(np.float64)
    return np.asarray(np.linalg.norm(wide - _running_median(imu.stamps_ns, wide, window_s), axis=1))


def _running_median(
    stamps_ns: Int64[Array, " samples"], values: Float64[Array, "samples columns"], window_s: float
) -> Float64[Array, "samples columns"]:
    period_s = max(float(np.median(np.diff(stamps_ns))) * 1e-9, 1e-6)
    size = min(2 * round(window_s / period_s / 2) + 1, 2 * len(values) - 1)
    columns = [median_filter(np.ascontiguousarray(column), size=size, mode="nearest") for column in values.T]
    return np.stack(columns, axis=1)


def _tilt_of_gravity(imu: ImuSignal, window_s: float) -> Float64[Array, " samples"] | None:
    gravity = _running_median(imu.stamps_ns, imu.acceleration.astype(np.float64), window_s)
    upright = np.median(gravity, axis=0)
    length = np.linalg.norm(gravity, axis=1)
    if np.linalg.norm(upright) < 1.0:
        return None
    cosine = gravity @ upright / np.maximum(length * np.linalg.norm(upright), 1e-9)
    # A free fall or an empty sample has no direction: it tilts nothing.
    return np.where(length > 1.0, np.arccos(cosine.clip(-1.0, 1.0)), 0.0)


def _lasting(
    signals: Signals, flags: Bool[Array, " rows"], at_least_s: float, reason: str, confidence: float
) -> tuple[LabelInterval, ...]:
    found = []
    for first, stop in runs(flags):
        start_ns, end_ns = int(signals.stamps_ns[first]), int(signals.stamps_ns[stop - 1]) + signals.period_ns
        if end_ns - start_ns >= round(at_least_s * 1e9):
            found.append(LabelInterval(start_ns, end_ns, FAILURE, reason, confidence))
    return tuple(found)


def _why_not(*checks: tuple[bool, str]) -> str | None:
    return next((reason for wrong, reason in checks if wrong), None)
