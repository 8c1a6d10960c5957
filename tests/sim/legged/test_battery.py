from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from navtool.base.setting_error import SettingError
from navtool.pipeline.arrays import Array
from navtool.sim.legged.battery import BatteryConfig, current_and_voltage, drawn_power
from navtool.sim.legged.body import STEP_S
from navtool.sim.legged.gaits import GaitName
from navtool.sim.legged.track import LeggedTrack

some = arrays(np.float64, (5, 12), elements=st.floats(-100, 100))


@given(some, some, st.floats(0, 1))
def test_no_work_is_done_for_nothing(torque: Array, rate: Array, regenerated: float) -> None:
    power = drawn_power(torque, rate, BatteryConfig(regenerated=regenerated))
    assert (power >= (torque * rate).sum(axis=1) + BatteryConfig().idle_w - 1e-6).all()
    assert (power <= drawn_power(torque, rate, BatteryConfig()) + 1e-6).all(), "what flows back is drawn no more"


@pytest.mark.parametrize("gait", list(GaitName))
def test_on_a_drive_the_battery_gives_more_than_the_joints_take(
    gait: GaitName, on_concrete: Callable[[GaitName], LeggedTrack]
) -> None:
    track = on_concrete(gait)
    work_j = (track.truth.torque_nm * track.truth.joint_radps).sum() * STEP_S
    current, voltage = track.measured.battery.T
    drawn_j = -(current * voltage).sum() * 0.1
    assert drawn_j > work_j + 0.9 * BatteryConfig().idle_w * 5.0
    assert work_j > 0, "walking on level ground costs work: impacts and gears"


@given(st.floats(0, 2000))
def test_current_times_voltage_is_the_power(power_w: float) -> None:
    current, voltage = current_and_voltage(np.full(100, power_w), 1.0, BatteryConfig())
    assert current * voltage == pytest.approx(np.full(100, power_w), rel=1e-6, abs=1e-6)
    assert (np.diff(voltage) <= 0).all()
    assert voltage[0] <= BatteryConfig().full_v


def test_the_published_energy_lasts_as_long_as_published() -> None:
    config = BatteryConfig()
    assert config.energy_wh / config.idle_w == pytest.approx(3.0, rel=0.01), "180 minutes of standby"


def test_a_battery_without_resistance_is_refused() -> None:
    with pytest.raises(SettingError, match="resistance"):
        BatteryConfig(resistance_ohm=0.0)
    with pytest.raises(SettingError, match="regenerated"):
        BatteryConfig(regenerated=1.5)
