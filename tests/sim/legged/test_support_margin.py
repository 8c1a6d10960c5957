import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from navtool.sim.legged.support_margin import inward

FEET = [[0.3, 0.17, 0.0], [0.3, -0.17, 0.0], [-0.3, 0.17, 0.0], [-0.3, -0.17, 0.0]]
legs = st.integers(0, 3)
place = st.floats(-0.1, 0.1)


def distance_inside(leg: int, x_m: float, y_m: float) -> float:
    """How far a point is from the line beside the stepping foot, above 0 on the side of the opposite foot."""
    a, b = (FEET[other] for other in range(4) if other not in (leg, 3 - leg))
    cross = (b[0] - a[0]) * (y_m - a[1]) - (b[1] - a[1]) * (x_m - a[0])
    opposite = FEET[3 - leg]
    side = (b[0] - a[0]) * (opposite[1] - a[1]) - (b[1] - a[1]) * (opposite[0] - a[0])
    return math.copysign(1.0, side) * cross / math.hypot(b[0] - a[0], b[1] - a[1])


@given(legs, place, place, st.floats(0.0, 0.08))
def test_the_way_inward_ends_at_the_wanted_distance_and_is_the_shortest(
    leg: int, x_m: float, y_m: float, wanted_m: float
) -> None:
    way = inward(FEET, leg, (x_m, y_m), wanted_m)
    before, after = distance_inside(leg, x_m, y_m), distance_inside(leg, x_m + way.x_m, y_m + way.y_m)
    if before >= wanted_m:
        assert way == (0.0, 0.0)
    elif wanted_m - before < 0.12:
        assert after == pytest.approx(wanted_m, abs=1e-12)
    assert math.hypot(*way) == pytest.approx(min(max(wanted_m - before, 0.0), 0.12), abs=1e-12)


def test_it_moves_away_from_the_stepping_foot() -> None:
    way = inward(FEET, 0, (0.0, 0.0), 0.05)
    assert way.x_m < 0
    assert way.y_m < 0


def test_feet_on_one_spot_give_no_direction() -> None:
    assert inward([[0.0, 0.0, 0.0]] * 4, 1, (0.1, 0.1), 0.05) == (0.0, 0.0)
