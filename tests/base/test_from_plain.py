"""Typed values out of plain ones: tuples, mappings, unions and subclasses."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import pytest

from navtool.base.from_plain import from_plain
from navtool.base.plain import plain
from navtool.base.setting_error import SettingError


@dataclass(kw_only=True)
class Wheel:
    """Anything that turns."""


@dataclass(kw_only=True)
class Tyre(Wheel):
    bar: float = 2.0


@dataclass(kw_only=True)
class Cart:
    wheel: Wheel = field(default_factory=Tyre)
    shape: tuple[int | str, ...] = ()
    span: tuple[float, float] | None = None
    notes: Mapping[str, Any] = field(default_factory=dict)
    wheels: Mapping[str, Wheel] = field(default_factory=dict)


def read(content: object) -> Cart:
    return from_plain(Cart, content, where="cart.json", concrete={Wheel: Tyre})


@pytest.mark.parametrize(
    "cart",
    [
        Cart(),
        Cart(wheel=Tyre(bar=3.5), shape=("batch", 3, "width"), span=(0.0, 1.5), notes={"a": [1, None, {"b": "c"}]}),
        Cart(wheels={"left": Tyre(bar=1.0), "right": Tyre()}),
    ],
)
def test_what_was_made_plain_comes_back(cart: Cart) -> None:
    assert read(plain(cart)) == cart


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ({"shape": ["batch", 1.5]}, r"shape\[1\]: wanted a whole number, got 1\.5"),
        ({"shape": [True]}, r"shape\[0\]: wanted a whole number, got True"),
        ({"shape": "batch"}, "shape: wanted a list, got the text 'batch'"),
        ({"span": [1.0]}, "span: wanted 2 values, got 1"),
        ({"span": [1.0, "far"]}, r"span\[1\]: wanted a number, got the text 'far'"),
        ({"notes": []}, "notes: wanted keys and values, got a list"),
        ({"wheel": {"bar": "hard"}}, r"wheel\.bar: wanted a number"),
        ({"wheels": {"left": {"psi": 30}}}, r"wheels\.left\.psi: there is no such key, known are bar"),
    ],
)
def test_anything_else_is_named(content: object, message: str) -> None:
    with pytest.raises(SettingError, match=message):
        read(content)


def test_without_a_subclass_the_class_itself_is_built() -> None:
    with pytest.raises(SettingError, match=r"wheel\.bar: there is no such key"):
        from_plain(Cart, {"wheel": {"bar": 1.0}}, where="cart.json")
