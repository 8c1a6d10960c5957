"""From annotations to a threshold, and from its settings to scored maps."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import yaml
from intensity_drive import intensity_drive

HALVES = [
    {"class": "solid", "outline_m": [[3.95, 0.0], [4.2, 0.0], [4.2, 3.0], [3.95, 3.0]]},
    {"class": "pliable", "outline_m": [[3.95, -3.0], [4.2, -3.0], [4.2, 0.0], [3.95, 0.0]]},
]


@pytest.fixture
def truth(tmp_path: Path) -> Path:
    path = tmp_path / "truth.json"
    path.write_text(json.dumps({"frame_id": "odom", "obstacles": HALVES}))
    return path


def test_fitted_settings_make_maps_that_agree_with_the_annotations(
    navtool_here: Callable[..., Any], write_recording: Callable[..., Path], truth: Path, tmp_path: Path
) -> None:
    bag, fit, maps = write_recording("mcap", intensity_drive()), tmp_path / "fit", tmp_path / "maps"
    every = ("tried.every_s=0.2", "tried.heights_m=[0.5,0.75]")
    told = navtool_here("fit", "intensity_threshold", bag, *every, "--truth", truth, "--out", fit)
    assert told.code == 0, told.err
    assert "map.obstacles.threshold=" in told.out
    report = json.loads(
        navtool_here("fit", "intensity_threshold", bag, *every, "--truth", truth, "--out", fit, "--json").out
    )
    assert report["done_before"] is True
    drawn = ("outputs.mcap_every=0", "outputs.video_every=0", "outputs.arrays_every=0")
    options = ("--settings", fit / "settings.yaml", "--truth", truth, "--out", maps, "--json")
    made = navtool_here("intensity-map", bag, *drawn, *options)
    assert made.code == 0, made.err
    scores = json.loads(made.out)["scores"]
    assert scores["solid"]["f"] > 0.9 < scores["pliable"]["f"]
    assert scores["transparent"] == {"precision": None, "recall": None, "f": None}
    used = yaml.safe_load(navtool_here("intensity-map", "--settings", fit / "settings.yaml", "--cfg", "job").out)
    assert used["map"]["obstacles"]["threshold"] == report["settings"]["obstacles.threshold"]
    overridden = navtool_here(
        "intensity-map", "--settings", fit / "settings.yaml", "map.obstacles.threshold=0.9", "--cfg", "job"
    )
    assert yaml.safe_load(overridden.out)["map"]["obstacles"]["threshold"] == 0.9


@pytest.mark.parametrize(
    ("content", "told"),
    [
        ("", "holds no settings"),
        ("- 1", "holds no settings"),
        ("a: [", "is not YAML"),
        ("map: {grid: [1]}", "map.grid is"),
    ],
)
def test_files_that_are_no_settings(navtool_here: Callable[..., Any], tmp_path: Path, content: str, told: str) -> None:
    path = tmp_path / "settings.yaml"
    path.write_text(content)
    done = navtool_here("intensity-map", "x.bag", "--settings", path, "--out", tmp_path / "out")
    assert done.code == 2
    assert told in done.err


def test_settings_hold_for_their_own_sensor(navtool_here: Callable[..., Any], tmp_path: Path) -> None:
    path = tmp_path / "settings.yaml"
    path.write_text("sensor: hesai\nmap: {obstacles: {threshold: 0.4}}\n")
    done = navtool_here("intensity-map", "x.bag", "--settings", path, "sensor=vlp16", "--out", tmp_path / "out")
    assert (done.code, "both name a sensor" in done.err) == (2, True)


def test_calls_that_cannot_be_meant(
    navtool_here: Callable[..., Any], write_recording: Callable[..., Path], truth: Path, tmp_path: Path
) -> None:
    bag, out = write_recording("mcap", intensity_drive(clouds=2)), tmp_path / "out"
    verb = ("fit", "intensity_threshold")
    for arguments, told in (
        ((), "no recording or data set was named"),
        ((bag,), "pass --out"),
        ((bag, bag, "--truth", truth, "--out", out), "one --truth for several inputs"),
        ((bag, "--truth", tmp_path / "absent.json", "--out", out), "no such file"),
        ((bag, "sensor=vlp17", "--out", out), "did you mean vlp16"),
        ((bag, "tried.heights_m=[]", "--out", out), "tried.heights_m: is empty"),
        ((bag, "--out", truth), "is a file"),
    ):
        done = navtool_here(*verb, *arguments)
        assert (done.code, told in done.err) == (2, True), (arguments, done.err)
    done = navtool_here(*verb, bag, "--out", out)
    assert done.code == 1
    assert "--truth" in done.err
    assert not out.exists()
