"""A setting that is refused is named by its whole key, whatever its dataclass calls it."""

from dataclasses import dataclass, field

import pytest

from navtool.base.errors import DatasetsError, NavtoolError
from navtool.base.from_plain import from_plain
from navtool.base.refusal import Refusal, dotted


@pytest.mark.parametrize(
    ("group", "key", "whole"),
    [
        ("", "fps", "fps"),
        ("drive", "duration_s", "drive.duration_s"),
        ("robot.topics", "topics.imu", "robot.topics.imu"),
        ("robot.joy", "joy", "robot.joy"),
        ("sync", "sync.odometry.tolerance_s", "sync.odometry.tolerance_s"),
        ("sync.odometry", "sync.odometry.tolerance_s", "sync.odometry.tolerance_s"),
        ("scenario.regions[1]", "share", "scenario.regions[1].share"),
    ],
)
def test_keys_are_joined_where_they_overlap(group: str, key: str, whole: str) -> None:
    assert dotted(group, key) == whole
    assert dotted(group, whole) == whole


@pytest.mark.parametrize(
    ("error", "group", "refused"),
    [
        (ValueError("hz is 0 Hz"), "camera", Refusal(None, "camera.hz is 0 Hz", None)),
        (ValueError("camera.hz is 0 Hz"), "camera", Refusal(None, "camera.hz is 0 Hz", None)),
        (ValueError("a picture of 0x0 px"), "camera", Refusal("camera", "a picture of 0x0 px", None)),
        (ValueError("hz is 0 Hz"), "", Refusal(None, "hz is 0 Hz", None)),
        (NavtoolError("is 0", where="hz", cure="more"), "camera", Refusal("camera.hz", "is 0", "more")),
        (NavtoolError("is 0"), "camera", Refusal("camera", "is 0", None)),
    ],
)
def test_what_an_error_says_begins_with_the_whole_key(
    error: NavtoolError | ValueError, group: str, refused: Refusal
) -> None:
    assert Refusal.of(error, group, ("hz", "width")) == refused


@dataclass
class Camera:
    hz: float = 30.0
    width: int = 640

    def __post_init__(self) -> None:
        if self.hz <= 0:
            raise ValueError(f"hz is {self.hz} Hz")
        if self.width <= 0:
            raise DatasetsError(f"{self.width} px", where="camera.width", cure="give more than 0")


@dataclass
class Rig:
    camera: Camera = field(default_factory=Camera)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ({"hz": 0}, "rig.yaml: camera.hz is 0.0 Hz\n"),
        ({"width": 0}, "rig.yaml: camera.width: 0 px (give more than 0)\n"),
    ],
)
def test_a_file_is_refused_by_the_same_keys(content: dict[str, object], said: str) -> None:
    with pytest.raises(DatasetsError) as caught:
        from_plain(Rig, {"camera": content}, where="rig.yaml")
    assert str(caught.value).startswith(said)
