"""What 16 bits a sample are shown as."""

import numpy as np
import pytest

from navtool.datasets.decode.levels import FULL, Levels, levels_of


@pytest.mark.parametrize("bits", [8, 10, 12, 14, 16])
def test_a_camera_of_fewer_bits_is_shown_by_its_own_full_scale(bits: int) -> None:
    samples = np.linspace(0, (1 << bits) - 1, 64 * 48).reshape(48, 64).astype(np.uint16)
    levels = levels_of([samples])
    assert levels == Levels(0, (1 << bits) - 1)
    np.testing.assert_array_equal(levels.table[samples], samples >> (bits - 8))


def test_a_narrow_band_is_shown_from_black_to_white_with_room_to_both_sides() -> None:
    scene = np.linspace(7076, 7841, 64 * 48).reshape(48, 64).astype(np.uint16)
    levels = levels_of([scene, scene + 20])
    assert 6700 < levels.low < 7000
    assert 7900 < levels.high < 8200
    shown = levels.table[scene]
    assert shown.std() > 30
    assert (np.diff(shown.ravel().astype(int)) >= 0).all()
    assert not levels.outside(scene)
    assert levels.outside(scene + 1000)


def test_nothing_and_a_picture_of_one_value_give_a_whole_bit_depth() -> None:
    assert levels_of([]) == FULL
    assert levels_of([np.full((48, 64), 3000, np.uint16)]) == Levels(0, 4095)
