"""A wrong setting is named by the same dotted key from Python, a file and the command line."""

import math
from copy import copy
from dataclasses import dataclass, field, replace
from typing import Any

import pytest
from omegaconf import OmegaConf

from navtool.base.from_plain import from_plain
from navtool.base.setting_checks import fault, outside
from navtool.base.setting_error import Fault, SettingError, refuse
from navtool.cli.compose import to_typed


@dataclass
class Camera:
    hz: float = 30.0
    width: int = 640
    gain: float | None = None

    def __post_init__(self) -> None:
        odd = "give an even number"
        refuse(
            outside(self, 0, 60, "hz", unit="Hz", above=True),
            outside(self, 1, math.inf, "width", "gain"),
            fault("width", f"{self.width} px is odd", odd, when=bool(self.width % 2)),
        )


@dataclass
class Rig:
    camera: Camera = field(default_factory=Camera)
    spares: list[Camera] = field(default_factory=list)


CASES = [
    ({"hz": 0.0}, "hz: 0 Hz is outside (0, 60] Hz"),
    ({"hz": math.nan}, "hz: nan Hz is outside (0, 60] Hz"),
    ({"width": 3}, "width: 3 px is odd\n  cure: give an even number"),
    ({"gain": 0.5}, "gain: 0.5 is not 1 or more"),
]


@pytest.mark.parametrize(("content", "said"), CASES)
def test_the_key_stands_first_from_everywhere(content: dict[str, Any], said: str) -> None:
    with pytest.raises(SettingError) as python:
        replace(Camera(), **content)
    assert str(python.value) == said
    with pytest.raises(SettingError) as file:
        from_plain(Rig, {"camera": content}, where="rig.yaml")
    assert str(file.value).startswith(f"rig.yaml: camera.{said}\n") or str(file.value) == f"rig.yaml: camera.{said}"
    with pytest.raises(SettingError) as command:
        to_typed(OmegaConf.merge(OmegaConf.structured(Rig), {"camera": content}), Rig)
    assert str(command.value).startswith(f"camera.{said}")
    assert file.value.cure
    assert command.value.cure


def test_every_fault_is_named() -> None:
    content = {"camera": {"hz": 70.0, "width": -1}, "spares": [{}, {"hz": -1.0}]}
    keys = ["camera.hz", "camera.width", "camera.width", "spares[1].hz"]
    with pytest.raises(SettingError) as file:
        from_plain(Rig, content, where="rig.yaml")
    assert [found.key for found in file.value.faults] == keys
    assert "camera.width: -1 px is odd (give an even number); spares[1].hz: -1 Hz" in str(file.value)
    with pytest.raises(SettingError) as command:
        to_typed(OmegaConf.merge(OmegaConf.structured(Rig), content), Rig)
    assert command.value.faults == file.value.faults


def test_it_crosses_processes_whole() -> None:
    error = SettingError(Fault("hz", "0 Hz"), Fault("", "nothing", "more"), file="rig.yaml", cure="mend it").below("a")
    again = copy(error)
    assert (str(again), again.faults, again.file) == (str(error), error.faults, error.file)
    assert [found.key for found in again.faults] == ["a.hz", "a"]


@pytest.mark.parametrize(
    ("bounds", "inside", "outer"),
    [
        ({}, [0.0, 0.5, 1.0], [-0.1, 1.1, math.nan, math.inf]),
        ({"above": True}, [0.1, 1.0], [0.0]),
        ({"below": True}, [0.0, 0.9], [1.0]),
    ],
)
def test_bounds_belong_to_the_interval_or_not(bounds: dict[str, Any], inside: list[float], outer: list[float]) -> None:
    def faults(value: float) -> list[Fault]:
        return outside(type("Settings", (), {"share": value}), 0, 1, "share", **bounds)

    assert not any(faults(value) for value in inside)
    assert all(faults(value) for value in outer)
