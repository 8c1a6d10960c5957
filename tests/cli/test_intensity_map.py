"""``navtool intensity-map`` as a user calls it."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from intensity_drive import intensity_drive

from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.ingest.ingest import ingest
from navtool.datasets.robot.config import RobotConfig

type Call = Callable[..., tuple[int, str, str]]


@pytest.fixture
def call(navtool_here: Callable[..., Any]) -> Call:
    """``call(*arguments)``: the command's exit code and what it printed."""

    def run(*arguments: object) -> tuple[int, str, str]:
        done = navtool_here("intensity-map", *arguments)
        return done.code, done.out, done.err

    return run


@pytest.fixture
def bag(write_recording: Callable[..., Path]) -> Path:
    return write_recording("mcap", intensity_drive())


def test_a_bag_becomes_maps(navtool: Callable[..., Any], bag: Path, tmp_path: Path) -> None:
    out = tmp_path / "maps"
    made = navtool("intensity-map", bag, "--out", out, "--json", "outputs.pictures_every=4", "sensor=simulated")
    assert made.code == 0, made.err
    told = json.loads(made.out)
    assert (told["clouds"], told["maps"], told["sensor"], told["done_before"]) == (8, 8, "simulated", False)
    assert told["maps_per_s"] > 0
    assert sorted(path.name for path in out.iterdir()) == [
        *("arrays", "index.html", "lineage.json", "map.mp4", "maps.csv", "maps.mcap", "pictures")
    ]
    with np.load(out / "arrays" / "000000.npz", allow_pickle=False) as found:
        assert found["classes"].shape == (200, 200)
    lineage = json.loads((out / "lineage.json").read_text())
    assert len(lineage["made_from"]["input"]) == 64


def test_again_it_is_done_and_otherwise_refused(call: Call, bag: Path, tmp_path: Path) -> None:
    few = ("outputs.video_every=0", "outputs.mcap_every=0", "outputs.pictures_every=0")
    assert call(bag, "--out", tmp_path / "maps", *few)[0] == 0
    code, out, err = call(bag, "--out", tmp_path / "maps", *few)
    assert code == 0
    assert "there already" in err
    assert "8 maps of 8 clouds" in out
    code, _, err = call(bag, "--out", tmp_path / "maps")
    assert code == 2
    assert "outputs.pictures_every (was 0, now" in err


def test_a_data_set_becomes_maps(call: Call, bag: Path, tmp_path: Path) -> None:
    ingest([bag], tmp_path / "set", RobotConfig(), IngestConfig())
    code, out, err = call(tmp_path / "set", "--out", tmp_path / "maps", "--episode", 0, "outputs.video_every=0")
    assert code == 0, err
    assert "8 maps of 8 clouds" in out
    assert json.loads((tmp_path / "maps" / "lineage.json").read_text())["input"]["episode"] == 0
    for wrong, said in (
        ("--episode=1", "there is no episode 1"),
        ("robot=husky", "knows its own robot"),
        ("sync.lidar.clock=record", "has its clocks already"),
    ):
        code, _, err = call(tmp_path / "set", "--out", tmp_path / "other", wrong)
        assert code == 2
        assert said in err


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ((), "no recording or data set was named"),
        (("BAG",), "pass --out FOLDER"),
        (("BAG", "BAG2", "--out", "OUT"), "2 inputs were named"),
        (("missing.mcap", "--out", "OUT"), "there is no such file"),
        (("BAG", "--out", "FULL"), "holds something else"),
        (("BAG", "--out", "OUT", "sensor=vlp6"), "did you mean vlp16?"),
        (("BAG", "--out", "OUT", "robot=nobody"), "no robot preset is called"),
        (("BAG", "--out", "OUT", "map.inflation.size_cells=301", "map.grid.cells=100"), "301"),
        (("BAG", "--out", "OUT", "map.grid.cells=16", "map.inflation.size_cells=21"), "is more than grid.cells = 16"),
        (("BAG", "--out", "OUT", "--episode", "0"), "is a recording: it has no episodes"),
        (("BAG", "--out", "OUT", "largest_intensity=9"), "is less than map.layers.full_scale"),
    ],
)
def test_wrong_calls_are_reported_as_such(
    call: Call, bag: Path, tmp_path: Path, arguments: tuple[str, ...], said: str
) -> None:
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "thesis.tex").touch()
    named = {"BAG": bag, "BAG2": bag, "OUT": tmp_path / "maps", "FULL": tmp_path / "full"}
    code, _, err = call(*(named.get(argument, argument) for argument in arguments))
    assert code == 2
    assert said in err
    assert not (tmp_path / "maps").exists()


def test_an_input_that_cannot_be_mapped_fails(call: Call, bag: Path, tmp_path: Path) -> None:
    code, _, err = call(bag, "--out", tmp_path / "maps", "sensor=hdl64")
    assert code == 1
    assert "gives at most 1" in err
    assert "cure: choose the preset of the recording's sensor with sensor=" in err
    assert not (tmp_path / "maps").exists()
