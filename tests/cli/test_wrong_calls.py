"""A wrong call is refused with the word that was meant, exit code 2, and JSON for a program that asked."""

import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from navtool.cli.main import main


@pytest.mark.parametrize(
    ("command", "override", "cure"),
    [
        ("ingest", "sync.camera.method=cubic", "use sync.camera.method=nearest or hold"),
        ("ingest", "sync.imu.method=cubic", "use sync.imu.method=nearest or hold or linear"),
        ("ingest", "merge=all", "use merge=file or folder"),
        ("ingest", "sync.lidar.clock=wall", "use sync.lidar.clock=auto or header or record"),
        ("train", "trainer.device=tpu", "use trainer.device=auto or cpu or cuda or mps"),
    ],
)
def test_a_refused_choice_names_those_that_are_taken(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], command: str, override: str, cure: str
) -> None:
    options = ["--data", "x"] if command == "train" else ["a.bag", "--out", "x"]
    monkeypatch.setattr(sys, "argv", ["navtool", command, *options, override])
    with pytest.raises(SystemExit) as left:
        main()
    said = capsys.readouterr().err
    assert left.value.code == 2
    assert f"{override}: there is no such value as" in said
    assert said.strip().endswith(cure)


@pytest.mark.parametrize(
    ("override", "meant"),
    [
        ("sync.image.method=hold", "did you mean 'camera'"),
        ("robot.topics.image=[/front]", "did you mean 'camera'"),
        ("robot.mounting.image={}", "did you mean 'camera'"),
        ("fsp=5", "did you mean 'fps'"),
        ("sync.imu.methd=hold", "no setting sync.imu.methd (did you mean 'method'"),
        ("method=hold", "did you mean 'sync."),
        ("sync.cameras.rear.toleranc=1", "did you mean 'tolerance_s'"),
        ("quite.another=1", "no setting quite"),
        ("place={parnt}", "\"place='{parnt}'\""),
    ],
)
def test_an_unknown_key_is_refused_with_the_one_that_was_meant(
    navtool_here: Callable[..., Any], override: str, meant: str
) -> None:
    refused = navtool_here("ingest", "a.bag", "--out", "x", override)
    assert (refused.code, meant in refused.err) == (2, True), refused.err


@pytest.mark.parametrize(
    ("arguments", "code", "what"),
    [
        (("check", "nosuch"), 2, "there is no such file or folder"),
        (("check", "--nosuch"), 2, "No such option: --nosuch"),
        (("ingest", "a.bag", "--out", "x", "fsp=5"), 2, "there is no setting fsp (did you mean 'fps'?)"),
        (("inspect", __file__), 1, "this is not a recording"),
    ],
)
def test_a_program_is_told_what_is_wrong(
    navtool_here: Callable[..., Any], arguments: tuple[str, ...], code: int, what: str
) -> None:
    refused = navtool_here(*arguments, "--json")
    told = json.loads(refused.out)["error"]
    assert (refused.code, told["exit_code"]) == (code, code)
    assert what in told["what"]
    assert told["what"] in refused.err, "a person is told as well"


def test_a_data_set_of_other_settings_is_a_wrong_call(
    navtool_here: Callable[..., Any],
    write_recording: Callable[..., Path],
    drive_entries: Callable[..., Any],
    tmp_path: Path,
) -> None:
    path = write_recording("mcap", drive_entries(1.0))
    assert navtool_here("ingest", path, "--out", tmp_path / "out").code == 0
    other = navtool_here("ingest", path, "--out", tmp_path / "out", "fps=5")
    assert other.code == 2, other.err
    assert "fps=10" in other.err


def test_a_named_topic_that_is_not_there_is_refused_but_not_a_presets(
    navtool_here: Callable[..., Any],
    write_recording: Callable[..., Path],
    drive_entries: Callable[..., Any],
    tmp_path: Path,
) -> None:
    path = write_recording("mcap", drive_entries(1.0))
    named = ("ingest", path, "--dry-run", "--json", "--out", tmp_path / "out")
    refused = navtool_here(*named, "robot.topics.lidar=[/nosuch]")
    assert refused.code == 1
    (entry,) = json.loads(refused.out)["quarantined"]
    assert "lidar: none of /nosuch" in entry["reason"]
    assert "navtool inspect" in entry["reason"]
    assert navtool_here(*named, "robot.topics.lidar=[/nosuch]", "--allow-missing").code == 0
    assert navtool_here(*named, "robot=jackal").code == 0, "a preset lists candidates"
    written = tmp_path / "robot.yaml"
    written.write_text("topics: {imu: [/nosuch], battery: [none]}")
    refused = navtool_here(*named, "--robot", written)
    assert [entry["reason"].count("/nosuch") for entry in json.loads(refused.out)["quarantined"]] == [1]


def test_near_misses_are_named(navtool_here: Callable[..., Any], tmp_path: Path) -> None:
    typo = navtool_here("ingest", "a.bag", "--out", str(tmp_path / "out"), "robot=jakal")
    assert typo.code == 2
    assert "did you mean jackal?" in typo.err
    added = navtool_here("ingest", "a.bag", "--out", str(tmp_path / "out"), "+fpss=3")
    assert added.code == 2
    assert "+fpss=3: there is no such setting to add" in added.err
    mine = tmp_path / "mine.yaml"
    mine.write_text("name: kept")
    kept = navtool_here("inspect", mine, "--write-robot", mine)
    assert kept.code == 2
    assert mine.read_text() == "name: kept"
