import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from navtool.base.setting_error import SettingError
from navtool.pipeline.arrays import Array
from navtool.sim.sensors.camera_config import CameraConfig
from navtool.sim.sensors.exposure import Exposure, choose_exposure, develop

CONFIG = CameraConfig()


def flat(value: float) -> Array:
    return np.full((80, 80, 3), value, np.float32)


def linear(grey: Array) -> Array:
    share = grey.astype(np.float64) / 255
    return np.asarray(np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4))


@given(st.floats(1.0, 1e5))
def test_the_mean_comes_to_the_target_while_the_limits_allow_it(lux: float) -> None:
    exposure = choose_exposure(flat(0.4), lux, CONFIG)
    mean = 0.4 * lux * exposure.shutter_s * CONFIG.electrons_per_lux_s * exposure.gain / CONFIG.full_well
    assert CONFIG.shortest_shutter_s <= exposure.shutter_s <= CONFIG.longest_shutter_s
    assert 1 <= exposure.gain <= CONFIG.largest_gain
    if exposure.shutter_s == CONFIG.shortest_shutter_s:
        assert mean >= CONFIG.target * (1 - 1e-4)
    elif exposure.gain < CONFIG.largest_gain:
        assert mean == pytest.approx(CONFIG.target, rel=1e-4)
    else:
        assert mean <= CONFIG.target * (1 + 1e-4)
    assert exposure.gain == 1 or exposure.shutter_s == CONFIG.longest_shutter_s, "longer first, then amplified"


def test_noise_is_that_of_photons_and_read_out() -> None:
    exposure = Exposure(0.01, 1.0)
    for lux in (100.0, 500.0, 1000.0):
        rgb = develop(flat(0.5), lux, exposure, CONFIG, np.random.default_rng(0))
        electrons = linear(rgb) * CONFIG.full_well
        expected = 0.5 * lux * exposure.shutter_s * CONFIG.electrons_per_lux_s
        assert electrons.mean() == pytest.approx(expected, rel=0.02)
        assert electrons.std() == pytest.approx(np.sqrt(expected + CONFIG.read_noise**2), rel=0.15)


def test_gain_makes_darkness_grainy() -> None:
    spread = []
    for lux in (1000.0, 30.0, 1.0):
        exposure = choose_exposure(flat(0.4), lux, CONFIG)
        grey = develop(flat(0.4), lux, exposure, CONFIG, np.random.default_rng(0)).astype(np.float64)
        spread.append(grey.std() / grey.mean())
    assert spread[0] < spread[1] < spread[2]


def test_too_much_light_saturates() -> None:
    rgb = develop(flat(1.0), 1e5, Exposure(0.03, 1.0), CONFIG, np.random.default_rng(0))
    assert (rgb == 255).all()


@given(st.integers(0, 1000))
def test_equal_generators_develop_equal_pictures(seed: int) -> None:
    light = np.random.default_rng(seed).random((8, 8, 3), np.float32)
    one, two = (develop(light, 300.0, Exposure(0.01, 2.0), CONFIG, np.random.default_rng(seed)) for _ in range(2))
    assert (one == two).all()


def test_wrong_settings_are_refused() -> None:
    for wrong in ({"shutter_s": 0.0}, {"largest_gain": 0.5}, {"dirt_share": 2.0}, {"edge_rays": 9}, {"full_well": 0.0}):
        with pytest.raises(SettingError, match=r"."):
            CameraConfig(**wrong)
