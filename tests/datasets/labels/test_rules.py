"""Rules on drives with a known fault: each finds its own, leaves a good drive alone, and says when it cannot tell."""

import dataclasses
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from navtool.base.setting_error import SettingError
from navtool.datasets.labels.config import CollisionConfig, FallConfig, InterventionConfig, LabelConfig, StuckConfig
from navtool.datasets.labels.intervals import LabelInterval
from navtool.datasets.labels.rules import (
    FlagSignal,
    ImuSignal,
    Signals,
    apply_rules,
    collision,
    fall,
    intervention,
    stuck,
    without_gravity,
)

PERIOD = 100_000_000
ROWS = 200
START = 1_600_000_000_000_000_000
CRASH_S = 10.0
Array = np.ndarray[tuple[int, ...], np.dtype[np.float64]]


def turned(axis: Array, angle: float) -> Array:
    """Rotation matrix about an axis."""
    x, y, z = axis / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    rotation: Array = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    return rotation


def imu(
    rate_hz: int = 200, noise: float = 0.3, spike: float = 0.0, spike_s: float = CRASH_S, tilt: float = 0.0
) -> ImuSignal:
    """Gravity, noise, a spike of 20 ms at ``spike_s``, and a roll by ``tilt`` from there on."""
    stamps = START + (np.arange(20 * rate_hz) * (1e9 / rate_hz)).astype(np.int64)
    time_s = (stamps - START) * 1e-9
    acceleration = np.tile([0.0, 0.0, 9.81], (stamps.size, 1))
    acceleration[time_s >= spike_s] = turned(np.array([1.0, 0.0, 0.0]), -tilt) @ [0.0, 0.0, 9.81]
    acceleration += np.random.default_rng(0).normal(0.0, noise, acceleration.shape)
    acceleration[(time_s >= spike_s) & (time_s < spike_s + 0.02), 0] -= spike
    return ImuSignal(stamps, acceleration)


def signals(
    speed: Array | None = None,
    command: Array | None = None,
    roll: Array | None = None,
    sensor: ImuSignal | None = None,
    flag: FlagSignal | None = None,
) -> Signals:
    zeros = np.zeros(ROWS)
    state = np.column_stack([zeros + 1.0 if speed is None else speed, zeros])
    action = state.copy() if command is None else np.column_stack([command, zeros])
    pose = np.zeros((ROWS, 6))
    pose[:, 3] = zeros if roll is None else roll
    valid = np.ones(ROWS, dtype=np.bool_)
    return Signals(
        stamps_ns=START + np.arange(ROWS, dtype=np.int64) * PERIOD,
        state=state,
        action=action,
        pose=pose,
        state_valid=valid,
        action_valid=valid if command is not None else ~valid,
        period_ns=PERIOD,
        imu=sensor,
        intervention=flag,
    )


def seconds(interval: LabelInterval) -> tuple[float, float]:
    return (interval.start_ns - START) * 1e-9, (interval.end_ns - START) * 1e-9


def stopping_at(row: int, rows: int = ROWS) -> Array:
    return np.where(np.arange(ROWS) < row, 1.0, np.where(np.arange(ROWS) < row + rows, 0.0, 1.0))


def test_a_spike_with_a_stop_is_a_collision() -> None:
    (crash,) = collision(signals(stopping_at(102), sensor=imu(spike=30.0)), CollisionConfig(after_s=1.0)).intervals
    start_s, end_s = seconds(crash)
    assert start_s == pytest.approx(CRASH_S, abs=0.01)
    assert end_s == pytest.approx(10.2 + 1.0, abs=1e-6)
    assert (crash.outcome, crash.reason, crash.confidence) == (0, "collision", 0.85)


def test_driving_on_ends_the_collision() -> None:
    (crash,) = collision(signals(stopping_at(102, rows=4), sensor=imu(spike=30.0)), CollisionConfig()).intervals
    assert seconds(crash)[1] == pytest.approx(10.6, abs=1e-6)


@pytest.mark.parametrize(
    ("speed", "sensor"),
    [
        pytest.param(stopping_at(102), imu(), id="a stop without a spike"),
        pytest.param(np.ones(ROWS), imu(spike=30.0), id="a spike without a stop"),
        pytest.param(stopping_at(120), imu(spike=30.0), id="a stop long after the spike"),
        pytest.param(stopping_at(80), imu(spike=30.0), id="a spike while standing"),
        pytest.param(stopping_at(102), imu(spike=30.0, noise=5.0), id="a spike within the robot's own vibration"),
        pytest.param(stopping_at(102), imu(spike=7.0, noise=0.01), id="a spike below the threshold"),
        pytest.param(stopping_at(102), imu(tilt=0.2), id="a slope"),
    ],
)
def test_neither_alone_is_a_collision(speed: Array, sensor: ImuSignal) -> None:
    result = collision(signals(speed, sensor=sensor), CollisionConfig())
    assert (result.intervals, result.not_applicable) == ((), None)


@settings(max_examples=20)
@given(axis=st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda v: np.linalg.norm(v) > 0.1), angle=st.floats(-3.1, 3.1))
def test_gravity_may_be_on_any_axis(axis: tuple[float, float, float], angle: float) -> None:
    upright = imu(spike=30.0)
    mounted = ImuSignal(upright.stamps_ns, upright.acceleration @ turned(np.array(axis), angle).T)
    # The median of a turned vector is not the turned median, but nearly.
    np.testing.assert_allclose(without_gravity(mounted, 1.0), without_gravity(upright, 1.0), atol=0.3)
    found, expected = (
        collision(signals(stopping_at(102), sensor=sensor), CollisionConfig()) for sensor in (mounted, upright)
    )
    assert found == expected


def test_the_running_median_equals_a_plain_one() -> None:
    sensor = imu(rate_hz=50)
    residual = without_gravity(sensor, 0.5)
    for at in (100, 499, 501, 800):
        window = sensor.acceleration[at - 12 : at + 13]
        assert residual[at] == pytest.approx(float(np.linalg.norm(sensor.acceleration[at] - np.median(window, axis=0))))


def test_commanded_without_moving_is_stuck_from_the_shortest_time_on() -> None:
    config = StuckConfig(at_least_s=2.0)
    for rows, found in ((19, 0), (20, 1), (50, 1)):
        speed = stopping_at(60, rows)
        result = stuck(signals(speed, command=np.ones(ROWS)), config)
        assert len(result.intervals) == found
        for interval in result.intervals:
            assert seconds(interval) == pytest.approx((6.0, 6.0 + rows / 10))
            assert interval.reason == "stuck"


def test_standing_without_a_command_turning_and_missing_rows_are_not_stuck() -> None:
    standing = signals(stopping_at(60, 50), command=stopping_at(60, 50))
    assert stuck(standing, StuckConfig()).intervals == ()
    commanded = signals(stopping_at(60, 50), command=np.ones(ROWS))
    turning = dataclasses.replace(commanded, state=commanded.state + np.array([0.0, 0.5]))
    assert stuck(turning, StuckConfig()).intervals == ()
    holes = commanded.state_valid.copy()
    holes[60:110:15] = False
    assert stuck(dataclasses.replace(commanded, state_valid=holes), StuckConfig()).intervals == ()
    assert stuck(dataclasses.replace(commanded, action_valid=holes), StuckConfig()).intervals == ()


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_commanded_turn_on_the_spot_counts_in_both_senses(sign: float) -> None:
    still = signals(np.zeros(ROWS), command=np.zeros(ROWS))
    turn = dataclasses.replace(still, action=np.tile([0.0, sign * 0.5], (ROWS, 1)))
    (interval,) = stuck(turn, StuckConfig()).intervals
    assert seconds(interval) == pytest.approx((0.0, 20.0))


@pytest.mark.parametrize("angle", [-1.2, 1.2])
def test_a_fall_is_seen_in_the_attitude(angle: float) -> None:
    roll = np.where((np.arange(ROWS) >= 50) & (np.arange(ROWS) < 80), angle, 0.1)
    (interval,) = fall(signals(roll=roll), FallConfig()).intervals
    assert seconds(interval) == pytest.approx((5.0, 8.0))
    assert fall(signals(roll=roll), FallConfig(at_least_s=3.1)).intervals == ()
    assert fall(signals(roll=roll), FallConfig(tilt_rad=1.3)).intervals == ()


def test_with_a_planar_odometry_gravity_tells_of_the_fall_whatever_the_mounting() -> None:
    for mounting in (np.eye(3), turned(np.array([1.0, 0.5, 0.0]), 2.0)):
        sensor = imu(tilt=1.2, spike_s=15.0)
        sensor = ImuSignal(sensor.stamps_ns, sensor.acceleration @ mounting.T)
        (interval,) = fall(signals(sensor=sensor), FallConfig()).intervals
        assert seconds(interval) == pytest.approx((15.0, 20.0), abs=0.11)
        assert fall(signals(sensor=sensor), FallConfig(tilt_rad=1.3)).intervals == ()


def test_the_operators_flag_holds_until_the_next_message() -> None:
    flag = FlagSignal(
        START + (np.array([1.0, 2.0, 2.5, 4.0, 18.0]) * 1e9).astype(np.int64),
        np.array([False, True, True, False, True]),
    )
    found = intervention(signals(flag=flag), InterventionConfig()).intervals
    assert [seconds(interval) for interval in found] == [pytest.approx((2.0, 4.0)), pytest.approx((18.0, 20.0))]
    assert {interval.reason for interval in found} == {"intervention"}


def test_every_rule_says_why_it_cannot_tell() -> None:
    bare = signals()
    lost = dataclasses.replace(bare, state_valid=np.zeros(ROWS, dtype=np.bool_))
    constant = ImuSignal(imu().stamps_ns, np.zeros((imu().stamps_ns.size, 3)))
    off = LabelConfig(
        collision=CollisionConfig(enabled=False),
        stuck=StuckConfig(enabled=False),
        fall=FallConfig(enabled=False),
        intervention=InterventionConfig(enabled=False),
    )

    def reasons(of: Signals, config: LabelConfig | None = None) -> list[str | None]:
        results = apply_rules(of, config or LabelConfig())
        assert [result.rule for result in results] == ["collision", "stuck", "fall", "intervention"]
        return [result.not_applicable for result in results]

    no_flag = "no intervention stream"
    assert reasons(bare) == ["no imu", "no commands", "planar odometry and no imu", no_flag]
    assert reasons(lost)[2] == "no odometry and no imu"
    assert reasons(dataclasses.replace(lost, imu=imu(), action_valid=bare.state_valid)) == [
        "no odometry",
        "no odometry",
        None,
        no_flag,
    ]
    assert reasons(dataclasses.replace(bare, imu=constant))[::2] == [
        "the imu reads a constant",
        "planar odometry, and the imu measures no gravity",
    ]
    assert reasons(bare, off) == ["switched off"] * 4


@pytest.mark.parametrize(
    ("build", "said"),
    [
        (lambda: CollisionConfig(spike_mps2=0.0), "spike_mps2: 0 m/s2 is outside (0, 500] m/s2"),
        (lambda: CollisionConfig(speed_after_mps=0.5), "speed_after_mps: 0.5 m/s is outside (0, 0.3] m/s"),
        (lambda: StuckConfig(moved_mps=1.0), "moved_mps"),
        (lambda: FallConfig(tilt_rad=45.0), "tilt_rad: 45 rad is outside (0, 3.2] rad"),
        (lambda: InterventionConfig(confidence=1.5), "confidence: 1.5 is outside (0, 1]"),
        (lambda: LabelConfig(max_deviation_m=float("nan")), "max_deviation_m: nan m"),
    ],
)
def test_a_wrong_setting_is_named_with_its_unit(build: Callable[[], object], said: str) -> None:
    with pytest.raises(SettingError) as caught:
        build()
    assert said in str(caught.value)
