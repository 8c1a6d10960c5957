"""Lens models as drivers spell them."""

import pytest

from navtool.pipeline.geometry.lens_names import lens_of

FOUR = (-0.28, 0.07, 0.001, -0.0007)


@pytest.mark.parametrize(
    ("name", "model"),
    [
        ("plumb_bob", "plumb_bob"),
        ("Brown Conrady", "plumb_bob"),
        ("Modified Brown-Conrady", "plumb_bob"),
        ("radtan", "plumb_bob"),
        ("rational_polynomial", "rational_polynomial"),
        ("RATIONAL_POLYNOMIAL", "rational_polynomial"),
        ("thin_prism", "rational_polynomial"),
        ("fisheye", "equidistant"),
        ("equidistant", "equidistant"),
        ("kannala_brandt4", "equidistant"),
        ("Kannala Brandt4", "equidistant"),
    ],
)
def test_drivers_names_are_known(name: str, model: str) -> None:
    assert lens_of(name, FOUR) == (model, FOUR, "")


def test_zeros_that_keep_room_are_cut_off_and_an_ideal_lens_stays_ideal() -> None:
    assert lens_of("equidistant", (*FOUR, 0.0)).coefficients == FOUR
    assert lens_of("plumb_bob", (0.0,) * 5) == ("plumb_bob", (0.0,) * 5, "")
    assert lens_of("plumb_bob", (0.0,) * 3) == ("plumb_bob", (), "")
    assert lens_of("Inverse Brown Conrady", (0.0,) * 5) == ("none", (), "")
    assert lens_of("", ()) == ("none", (), "")
    assert lens_of("fisheye", ()) == ("equidistant", (), "")


def test_coefficients_without_a_name_count_and_are_told() -> None:
    for name in ("", "none"):
        model, coefficients, told = lens_of(name, FOUR)
        assert (model, coefficients) == ("plumb_bob", FOUR)
        assert "plumb_bob is taken" in told


@pytest.mark.parametrize(
    ("name", "coefficients", "told"),
    [
        ("mei", (), "known are none, plumb_bob"),
        ("Inverse Brown Conrady", FOUR, "known are"),
        ("plumb_bob", FOUR[:3], "has 3 coefficients; expected 4 to 14"),
        ("fisheye", (*FOUR, 0.1), "has 5 coefficients; expected 4"),
        ("rational_polynomial", (0.1,) * 15, "has 15 coefficients"),
    ],
)
def test_what_cannot_be_meant_is_refused(name: str, coefficients: tuple[float, ...], told: str) -> None:
    with pytest.raises(ValueError, match=told):
        lens_of(name, coefficients)
