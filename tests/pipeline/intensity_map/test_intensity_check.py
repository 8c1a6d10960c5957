"""What a recording's intensities have to be."""

import numpy as np
import pytest

from navtool.pipeline.intensity_map.intensity_check import judge_intensities


@pytest.mark.parametrize(
    ("intensity", "problem"),
    [
        ([], "no point"),
        ([np.nan], "no point"),
        ([0, 0, 0], "all intensities are 0"),
        ([-1, 100], "not negative"),
        ([0, 300], "full_scale"),
        ([0, 1], "full_scale"),
        ([255] * 199 + [10], "saturated"),
        ([255] * 97 + [10] * 3, None),
        (list(range(256)), None),
    ],
)
def test_intensities_that_cannot_carry_a_map_are_reported(intensity: list[float], problem: str | None) -> None:
    said = judge_intensities(np.array(intensity, np.float32), 255.0)
    assert said is None if problem is None else said is not None and problem in said
