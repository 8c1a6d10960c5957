"""``navtool intensity-map`` as a user calls it."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from intensity_drive import intensity_drive


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
    again = navtool("intensity-map", bag, "--out", out, "outputs.pictures_every=4")
    assert again.code == 0
    assert "there already" in again.err
    assert "8 maps of 8 clouds" in again.out
    other = navtool("intensity-map", bag, "--out", out)
    assert other.code == 1
    assert "another settings" in other.err


def test_a_data_set_becomes_maps(navtool: Callable[..., Any], bag: Path, tmp_path: Path) -> None:
    assert navtool("ingest", bag, "--out", tmp_path / "set").code == 0
    made = navtool("intensity-map", tmp_path / "set", "--out", tmp_path / "maps", "--episode", 0)
    assert made.code == 0, made.err
    assert "8 maps of 8 clouds" in made.out
    assert json.loads((tmp_path / "maps" / "lineage.json").read_text())["input"]["episode"] == 0


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
        (("BAG", "--out", "OUT", "largest_intensity=9"), "is less than map.layers.full_scale"),
    ],
)
def test_wrong_calls_are_told_as_such(
    navtool: Callable[..., Any], bag: Path, tmp_path: Path, arguments: tuple[str, ...], said: str
) -> None:
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "thesis.tex").touch()
    named = {"BAG": bag, "BAG2": bag, "OUT": tmp_path / "maps", "FULL": tmp_path / "full"}
    refused = navtool("intensity-map", *(named.get(argument, argument) for argument in arguments))
    assert refused.code == 2
    assert said in refused.err
    assert not (tmp_path / "maps").exists()


def test_an_input_that_cannot_be_mapped_fails(navtool: Callable[..., Any], bag: Path, tmp_path: Path) -> None:
    failed = navtool("intensity-map", bag, "--out", tmp_path / "maps", "sensor=hdl64")
    assert failed.code == 1
    assert "gives at most 1" in failed.err
    assert "cure: choose the preset of the recording's sensor with sensor=" in failed.err
    assert not (tmp_path / "maps").exists()
