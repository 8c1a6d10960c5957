"""A threshold fitted to a drive towards a wall that is strong to the left and weak to the right."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import yaml
from intensity_drive import HEIGHT_M, intensity_drive
from noted import noted
from walking import fit_intensity_threshold

from navtool.base.errors import DatasetsError
from navtool.base.setting_error import SettingError
from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.ingest.ingest import ingest
from navtool.datasets.robot.config import RobotConfig
from navtool.methods.along.source import Input
from navtool.methods.intensity_map.fit_report import FitReport
from navtool.methods.intensity_map.fit_threshold import ThresholdFitConfig
from navtool.methods.intensity_map.threshold import ThresholdRunConfig

LEFT = [[3.8, 0.0], [4.2, 0.0], [4.2, 3.2], [3.8, 3.2]]
RIGHT = [[3.8, -3.2], [4.2, -3.2], [4.2, 0.0], [3.8, 0.0]]
STRONG, WEAK = 240 / 255, 60 / 255
"""Intensities of both halves, in units of R."""
Write = Callable[..., Path]


@pytest.fixture
def truth(tmp_path: Path) -> Callable[..., Path]:
    """A factory of annotations: the left half and the right half of the wall."""

    def write(left: str = "solid", right: str = "pliable", frame: str = "odom", aside_m: float = 0.0) -> Path:
        halves = [(left, LEFT), (right, RIGHT)]
        outlines = [{"class": what, "outline_m": [[x, y + aside_m] for x, y in half]} for what, half in halves]
        path = tmp_path / f"{left}-{right}-{frame}.json"
        path.write_text(json.dumps({"frame_id": frame, "obstacles": outlines}))
        return path

    return write


def fit(path: Path, truth: Path | None, out: Path, episode: int | None = None, **tried: Any) -> FitReport:
    config = ThresholdRunConfig(tried=ThresholdFitConfig(every_s=0.0, **tried))
    return fit_intensity_threshold([Input(path, episode)], truth, out, config)


def test_the_threshold_lies_between_strong_and_weak(
    write_recording: Write, truth: Callable[..., Path], tmp_path: Path
) -> None:
    path = write_recording("mcap", intensity_drive())
    # 1.4 m above the ground nothing within 0.5 m of the sensor's height is left
    report = fit(path, truth(), tmp_path / "fit", heights_m=[0.5, 0.75], ground_margins_m=[1.4, 0.2])
    assert WEAK < report.settings["obstacles.threshold"] < STRONG
    assert report.tried[0].gain == pytest.approx(1.0, abs=0.1)
    assert [one.gain for one in report.tried] == sorted((one.gain for one in report.tried), reverse=True)
    assert len(report.tried) == 2 * 2
    assert report.tried[0].gain > report.tried[-1].gain + 0.1
    assert report.settings["layers.ground_margin_m"] == 0.2
    assert report.cells["solid"] > 20 < report.cells["pliable"]
    assert report.sensor_heights_m == pytest.approx([HEIGHT_M])
    settings = yaml.safe_load((tmp_path / "fit" / "settings.yaml").read_text())["map"]
    assert settings["obstacles"]["threshold"] == report.settings["obstacles.threshold"]
    assert settings["layers"]["height_m"] == report.settings["layers.height_m"] == report.tried[0].height_m
    assert "<svg" in (tmp_path / "fit" / "roc.svg").read_text()


def test_a_fit_that_is_there_is_told_again_and_another_refused(
    write_recording: Write, truth: Callable[..., Path], tmp_path: Path
) -> None:
    path, out = write_recording("mcap", intensity_drive()), tmp_path / "fit"
    first = fit(path, truth(), out)
    again = fit(path, truth(), out)
    assert again.done_before
    assert not first.done_before
    assert again.tried == first.tried
    with pytest.raises(DatasetsError, match=r"what is here was made with another tried\.heights_m"):
        fit(path, truth(), out, heights_m=[0.5])
    with pytest.raises(DatasetsError, match="what is here was made with another truth"):
        fit(path, truth("pliable", "solid"), out)


def test_what_is_labelled_the_wrong_way_round_gains_nothing(
    write_recording: Write, truth: Callable[..., Path], tmp_path: Path
) -> None:
    path = write_recording("mcap", intensity_drive())
    report = fit(path, truth("pliable", "solid"), tmp_path / "fit", heights_m=[0.5])
    assert report.tried[0].area < 0.2


def test_a_data_set_gives_the_same_fit(write_recording: Write, truth: Callable[..., Path], tmp_path: Path) -> None:
    path = write_recording("mcap", intensity_drive())
    ingest([path], tmp_path / "set", RobotConfig(), IngestConfig())
    one = fit(path, truth(), tmp_path / "of_bag")
    other = fit(tmp_path / "set", truth(), tmp_path / "of_set")
    assert (one.tried, one.cells, one.sweeps) == (other.tried, other.cells, other.sweeps)
    with pytest.raises(DatasetsError, match=r"nothing says what stands there(.|\n)*--truth"):
        fit(tmp_path / "set", None, tmp_path / "none")


def test_the_height_of_the_sensor_is_measured_where_nobody_tells_it(
    write_recording: Write, truth: Callable[..., Path], tmp_path: Path
) -> None:
    ground = [(x, y, -HEIGHT_M, 90.0) for x in (1.0, 1.5, 2.0, 2.5) for y in range(-40, 41)]
    path = write_recording("mcap", intensity_drive(footprint=False, bad=[(x, y / 20, z, i) for x, y, z, i in ground]))
    report = fit(path, truth(), tmp_path / "fit")
    assert report.sensor_heights_m == pytest.approx([HEIGHT_M], abs=0.02)
    (told,) = noted(report.notes, "height.measured")
    assert "as 8 sweeps show" in told


@pytest.mark.parametrize(
    ("left", "right", "told"),
    [("pliable", "pliable", "anything solid"), ("solid", "transparent", "anything pliable")],
)
def test_one_kind_alone_has_no_threshold(
    left: str, right: str, told: str, write_recording: Write, truth: Callable[..., Path], tmp_path: Path
) -> None:
    path = write_recording("mcap", intensity_drive())
    with pytest.raises(DatasetsError, match=f"no return came from {told}"):
        fit(path, truth(left, right), tmp_path / "fit")
    assert not (tmp_path / "fit").exists()


@pytest.mark.parametrize("tried", [{"heights_m": []}, {"ground_margins_m": [3.0]}, {"heights_m": [0.0]}])
def test_heights_that_cannot_be_tried(tried: dict[str, list[float]]) -> None:
    with pytest.raises(SettingError, match=f"^{next(iter(tried))}: "):
        ThresholdFitConfig(**tried)  # type: ignore[arg-type]


def test_outlines_in_another_frame_are_moved_or_refused(
    write_recording: Write, truth: Callable[..., Path], tmp_path: Path
) -> None:
    path = write_recording("mcap", intensity_drive())
    with pytest.raises(DatasetsError, match=r"in the frame 'map', the odometry of .* is in 'odom'"):
        fit(path, truth(frame="map"), tmp_path / "refused")
    entries = intensity_drive()
    (static,) = [fields for topic, *_, fields in entries if topic == "/tf_static"]
    pose = {"translation": {"x": 0.0, "y": 20.0, "z": 0.0}, "rotation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}}
    header = {**static["transforms"][0]["header"], "frame_id": "map"}
    static["transforms"].append({"header": header, "child_frame_id": "odom", "transform": pose})
    joined = write_recording("mcap", entries, name="joined")
    moved = fit(joined, truth(frame="map", aside_m=20.0), tmp_path / "moved")
    assert moved.tried == fit(path, truth(), tmp_path / "plain").tried


def test_what_speaks_against_a_fit_is_told(write_recording: Write, truth: Callable[..., Path], tmp_path: Path) -> None:
    path = write_recording("mcap", intensity_drive())
    wrong = fit(path, truth("pliable", "solid"), tmp_path / "fit", heights_m=[0.5, 0.6])
    assert noted(wrong.notes, "fit.weak")
    assert any("of tried.heights_m" in told for told in noted(wrong.notes, "fit.at-an-end"))
