"""Typed values as plain ones: what JSON can hold, and back."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from pathlib import Path

import numpy as np
import pytest

from navtool.base.from_plain import from_plain
from navtool.base.plain import LEFT_OUT_WHILE_EMPTY, flatten, plain, plain_fields


class Colour(Enum):
    red = 0
    green = 1


@dataclass
class Lens:
    width_px: int = 640
    colours: list[Colour] = field(default_factory=lambda: [Colour.green])


@dataclass
class Camera:
    lens: Lens = field(default_factory=Lens)
    rate_hz: float = 30.0
    offsets: dict[str, float] = field(default_factory=lambda: {"rear": 0.5})
    name: str | None = None


@pytest.mark.parametrize(
    ("value", "wanted"),
    [
        (np.float32(0.5), 0.5),
        (np.arange(4).reshape(2, 2), [[0, 1], [2, 3]]),
        (Path("a/b"), "a/b"),
        (Colour.red, "red"),
        ((1, {"a": Colour.green}), [1, {"a": "green"}]),
        ({1: b"raw"}, {"1": b"raw"}),
        (None, None),
    ],
)
def test_values_become_what_json_knows(value: object, wanted: object) -> None:
    assert plain(value) == wanted


def test_a_dataclass_survives_the_way_through_json() -> None:
    camera = Camera(Lens(320, [Colour.red, Colour.green]), 10.0, {"rear": 1.0, "front": 2.0}, "a")
    assert from_plain(Camera, json.loads(json.dumps(plain(camera))), where="file") == camera
    assert list(plain_fields(camera)) == ["lens", "rate_hz", "offsets", "name"]


def nested(leaves: Mapping[str, object]) -> dict[str, object]:
    """The inverse of ``flatten`` for keys without dots."""
    tree: dict[str, object] = {}
    for key, value in leaves.items():
        *above, name = key.split(".")
        part = tree
        for step in above:
            inner = part.setdefault(step, {})
            assert isinstance(inner, dict)
            part = inner
        part[name] = value
    return tree


def test_leaves_have_dotted_keys_and_say_all_there_is() -> None:
    leaves = flatten(Camera())
    assert leaves == {
        "lens.width_px": 640,
        "lens.colours": ["green"],
        "rate_hz": 30.0,
        "offsets.rear": 0.5,
        "name": None,
    }
    assert nested(leaves) == plain(Camera())
    assert flatten(plain(Camera())) == leaves
    assert flatten({}) == {}


@dataclass
class Rig:
    cameras: dict[str, Lens] = field(default_factory=dict, metadata=LEFT_OUT_WHILE_EMPTY)
    names: list[str] = field(default_factory=list)


def test_what_is_left_out_while_empty_comes_back_empty() -> None:
    assert plain(Rig()) == {"names": []}
    assert from_plain(Rig, plain(Rig()), where="file") == Rig()
    full = Rig({"rear": Lens(320, [])})
    assert plain(full) == {"cameras": {"rear": {"width_px": 320, "colours": []}}, "names": []}
    assert from_plain(Rig, plain(full), where="file") == full
