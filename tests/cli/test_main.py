"""The command tree is a contract: frozen here, with its help, version, completion and exit codes."""

import json
import re
import shlex
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml
from typer.main import get_command

from navtool.cli.arguments import split_overrides
from navtool.cli.inspect import print_inspection
from navtool.cli.main import app, main
from navtool.datasets.inspect.inspection import inspect_recording
from navtool.datasets.store.reader import NavDataset

TREE = {
    "inspect": ["bag", "--robot", "--write-robot", "--report", "--json"],
    "ingest": [
        "arguments",
        "--out",
        "--robot",
        "--workers",
        "--dry-run",
        "--allow-missing",
        "--strict",
        "--cfg",
        "--json",
    ],
    "label": ["dataset", "overrides", "--events", "--cfg", "--json"],
    "check": ["dataset", "--splits", "--json"],
    "delete": ["dataset", "episodes", "--out", "--json"],
    "split": ["dataset", "parts", "--out", "--json"],
    "merge": ["datasets", "--out", "--json"],
    "compact": ["dataset", "--out", "--json"],
    "migrate": ["dataset", "--out", "--json"],
    "train": ["overrides", "--data", "--out", "--multirun", "--cfg", "--resume", "--json"],
    "evaluate": ["source", "--data", "--split", "--out", "--json"],
    "export": ["run", "--out", "--overwrite", "--json"],
    "verify": ["artefact", "--latency-runs", "--json"],
    "intensity-map": ["arguments", "--out", "--settings", "--truth", "--episode", "--robot", "--cfg", "--json"],
    "simulate": ["overrides", "--out", "--episodes", "--seed", "--workers", "--preview", "--cfg", "--json"],
    "demo": ["--out", "--seed", "--episodes", "--seconds", "--epochs"],
    "fit": [],
}
FITS = {
    "intensity_threshold": ["arguments", "--out", "--truth", "--episode", "--robot", "--cfg", "--json"],
}


def _parameters(command: Any) -> list[str]:
    return [parameter.opts[0] for parameter in command.params]


def test_the_command_tree_is_frozen() -> None:
    root: Any = get_command(app)
    assert {name: _parameters(command) for name, command in root.commands.items()} == TREE
    fits = root.commands["fit"].commands
    assert {name: _parameters(command) for name, command in fits.items()} == FITS
    assert all(command.help for command in (*root.commands.values(), *fits.values()))


def test_help_and_version(navtool: Callable[..., Any]) -> None:
    shown = navtool("--help")
    assert shown.code == 0
    assert all(verb in shown.out for verb in TREE)
    version = navtool("--version")
    assert version.code == 0
    assert version.out.startswith("navtool 0.")
    assert navtool("check", "--help").code == 0


def test_completion_is_shown_to_the_shell_that_asks() -> None:
    program = Path(sys.executable).with_name("navtool")
    ask = ["bash", "-c", f"{shlex.quote(str(program))} --show-completion; exit $?"]
    shown = subprocess.run(ask, capture_output=True, text=True, check=True)  # noqa: S603
    assert "_NAVTOOL_COMPLETE" in shown.stdout


@pytest.mark.parametrize(
    ("command", "key"),
    [("ingest", "sync.camera.tolerance_s"), ("label", "max_deviation_m"), ("intensity-map", "map.grid.cell_m")],
)
def test_the_configuration_is_printed_with_its_overrides(
    navtool_here: Callable[..., Any], command: str, key: str
) -> None:
    shown = navtool_here(command, f"{key}=0.5", "--cfg", "job")
    assert shown.code == 0
    content = yaml.safe_load(shown.out)
    for part in key.split("."):
        content = content[part]
    assert content == 0.5
    assert navtool_here(command, "--cfg", "hydra").code == 2
    assert navtool_here(command).code == 2


def test_help_loads_nothing_heavy() -> None:
    heavy = ("torch", "numpy", "hydra", "rich", "pyarrow", "cv2")
    code = f"import sys, navtool.cli.main; print([name for name in {heavy} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)  # noqa: S603
    assert done.stdout.strip() == "[]"


@pytest.mark.parametrize("command", ["inspect", "ingest", "label", "check", "intensity-map"])
def test_reading_and_ingesting_load_no_torch(command: str) -> None:
    modules = {
        "inspect": "navtool.datasets.inspect.inspection",
        "ingest": "navtool.datasets.ingest.ingest, navtool.cli.robots; navtool.cli.robots.ingest_job(None, ())",
        "label": "navtool.datasets.labels.apply",
        "check": "navtool.datasets.check",
        "intensity-map": "navtool.methods.intensity_map.maps, navtool.methods.along.run",
    }
    heavy = ("torch", "lerobot", "datasets")
    code = f"import {modules[command]}; import sys; print([name for name in {heavy} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)  # noqa: S603
    assert done.stdout.strip() == "[]"


def test_paths_and_overrides_are_kept_apart(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "odd=name.bag").touch()
    given = ["a.bag", "fps=5", "odd=name.bag", "sync.camera.tolerance_s=0.1", "+new=1", "/data/x.mcap", "robot=husky"]
    paths, overrides = split_overrides(given)
    assert paths == ["a.bag", "odd=name.bag", "/data/x.mcap"]
    assert overrides == ["fps=5", "sync.camera.tolerance_s=0.1", "+new=1", "robot=husky"]


CALLS: list[tuple[str, int, str]] = [
    ("inspect", 2, "Missing argument"),
    ("inspect {absent}", 2, "there is no such file or folder"),
    ("inspect {text}", 1, "not a recording"),
    ("inspect {empty}", 1, "no recording in this folder"),
    ("inspect {text} --robot {absent}.yaml", 2, "cannot be read"),
    ("inspect {text} --robot {text}", 2, "wanted keys and values"),
    ("inspect {text} --robot unknown", 2, "no robot preset"),
    ("inspect {text} --report {absent}/run.html", 2, "there is no such folder"),
    ("inspect {text} --report {empty}", 2, "is a folder"),
    ("inspect {text} --write-robot {absent}/robot.yaml", 2, "there is no such folder"),
    ("inspect {text} --write-robot {text}", 2, "is there already"),
    ("ingest --out {out}", 2, "no recording was named"),
    ("simulate {out} --episodes 1", 2, "not of the form KEY=VALUE"),
    ("ingest {text}", 2, "--out"),
    ("ingest {absent} --out {out}", 2, "there is no such file or folder"),
    ("ingest {absent}/*.bag --out {out}", 2, "no file matches"),
    ("ingest {empty} --out {out}", 1, "holds no recording"),
    ("ingest {text} --out {out}", 1, "not a recording"),
    ("ingest {text} --out {text}", 2, "is a file"),
    ("ingest {text} --out {folder}", 2, "holds something else"),
    ("ingest {text} --out {out} --fast", 2, "--fast"),
    ("ingest {text} --out {out} --workers 0", 2, "--workers"),
    ("ingest {text} --out {out} --cfg hydra", 2, "--cfg job"),
    ("ingest {text} --out {out} fbs=5", 2, "fbs"),
    ("ingest {text} --out {out} fps=fast", 2, "fps"),
    ("ingest {text} --out {out} fps=600", 2, "600"),
    ("ingest {text} --out {out} robot=unknown", 2, "generic"),
    ("ingest {text} --out {out} robot.joy.turn_axis=2", 2, "into a robot file"),
    ("ingest {text} --out {out} --robot {absent}.yaml", 2, "absent.yaml"),
    ("label", 2, "0 data sets were named"),
    ("label {absent}", 2, "there is no such file or folder"),
    ("label {folder}", 1, "not a data set"),
    ("label {folder} --events {absent}", 2, "there is no such file or folder"),
    ("label {folder} stuck.at_least_s=-1", 2, "stuck.at_least_s"),
    ("check", 2, "Missing argument"),
    ("check {absent}", 2, "there is no such file or folder"),
    ("check {folder}", 1, "not a data set"),
    ("check {folder} --splits {absent}", 2, "there is no such file or folder"),
    ("check {folder} --splits {text}", 1, "notes.bag"),
    ("train", 2, "no data set was named"),
    ("train --data {absent}", 2, "there is no such file or folder"),
    ("train --data {folder} --out {folder}", 2, "holds other files"),
    ("train --data {folder} --out {out}", 1, "not a data set"),
    ("train --data {folder} trainer.epoch=3", 2, "trainer.epoch"),
    ("train --data {folder} trainer.epochs=0", 2, "trainer.epochs"),
    ("train --data {folder} model=unknown", 2, "graspe"),
    ("train --data {folder} --out {out} model.pretrained_image_weights={absent}", 2, "there is no such file or folder"),
    ("train --resume {absent}", 2, "there is no such file or folder"),
    ("train --resume {folder}", 1, "not a training run"),
    ("train --resume {folder} --out {out}", 2, "alone"),
    ("evaluate {absent}", 2, "there is no such file or folder"),
    ("evaluate {folder}", 1, "not a training run"),
    ("evaluate {folder} --data {absent}", 2, "there is no such file or folder"),
    ("evaluate {folder} --split best", 2, "use one of train"),
    ("evaluate {folder} --out {absent}/report.json", 2, "there is no such folder"),
    ("evaluate {artefact}", 2, "--data"),
    ("export {folder}", 2, "--out"),
    ("export {absent} --out {out}", 2, "there is no such file or folder"),
    ("export {folder} --out {out}", 1, "not a training run"),
    ("export {folder} --out {text}", 2, "is a file"),
    ("export {folder} --out {artefact}", 2, "--overwrite"),
    ("verify {absent}", 2, "there is no such file or folder"),
    ("verify {folder}", 1, "NOT VERIFIED"),
    ("verify {folder} --latency-runs 0", 2, "--latency-runs"),
    ("demo --out {folder}", 2, "not an empty folder"),
    ("demo --episodes 1", 2, "--episodes"),
    ("nonsense", 2, "No such command"),
]
"""2: the call is wrong. 1: what it names cannot be used."""


@pytest.mark.parametrize(("call", "code", "said"), CALLS, ids=[call for call, _, _ in CALLS])
def test_bad_input_gets_one_error_and_an_exit_code(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    call: str,
    code: int,
    said: str,
) -> None:
    names = ("absent", "text", "empty", "folder", "artefact", "out")
    paths = {name: tmp_path / name for name in names} | {"text": tmp_path / "notes.bag"}
    paths["text"].write_text("not a recording")
    for name in ("empty", "folder", "artefact"):
        paths[name].mkdir()
    (paths["folder"] / "letter.txt").write_text("dear all")
    (paths["artefact"] / "manifest.json").write_text("{}")
    before = _everything(tmp_path)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", ["navtool", *call.format(**paths).split()])
    with pytest.raises(SystemExit) as left:
        main()
    printed = capsys.readouterr()
    assert left.value.code == code, printed
    assert said in printed.err + printed.out
    assert _everything(tmp_path) == before


def _everything(folder: Path) -> dict[str, int]:
    """Every file by its size; what Hydra notes of a job and empty folders do not count."""
    files = (path for path in folder.rglob("*") if path.is_file() and ".hydra" not in path.parts)
    return {str(path): path.stat().st_size for path in files}


@pytest.mark.recordings
def test_inspect_json_counts_what_the_recording_holds(navtool: Callable[..., Any], recordings: Path) -> None:
    found = json.loads(navtool("inspect", recordings / "bags/husky_outdoor/test1.bag", "--json").out)
    assert {"path", "format", "start_ns", "end_ns", "messages", "topics", "topic_map"} <= set(found)
    counts = {topic["name"]: topic["count"] for topic in found["topics"]}
    assert counts == {"/imu/data": 11865, "/husky_velocity_controller/odom": 3952, "/fix": 989}
    assert {"name", "type", "count", "rate_hz", "gap_max_s"} <= set(found["topics"][0])
    assert found["topic_map"]["odometry"] == "/husky_velocity_controller/odom"


@pytest.mark.parametrize("width", [80, 140])
def test_topics_fit_into_a_terminal_and_nothing_of_them_is_lost(
    write_recording: Callable[..., Path],
    drive_entries: Callable[..., Any],
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    width: int,
) -> None:
    inspection = inspect_recording(write_recording("mcap", drive_entries()))
    monkeypatch.setenv("COLUMNS", str(width))
    for terminal in (True, False):
        monkeypatch.setattr(sys.stdout, "isatty", lambda terminal=terminal: terminal)
        print_inspection(inspection)
        lines = re.sub(r"\x1b\[[0-9;]*m", "", capsys.readouterr().out).splitlines()[1:]
        if terminal:
            assert max(map(len, lines)) <= width
        for topic in inspection.topics:
            row = [line.split() for line in lines if line.split()[:1] == [topic.name]]
            words = [word for found in row for word in found]
            assert {topic.type, str(topic.count), f"{topic.rate_hz:.4g}" if topic.rate_hz else "-"} <= set(words), row
        assert len([line for line in lines if line.strip() == "Messages"]) == (terminal and width == 80)


def test_a_robot_file_comes_back(
    navtool_here: Callable[..., Any],
    write_recording: Callable[..., Path],
    drive_entries: Callable[..., Any],
    tmp_path: Path,
) -> None:
    bag = write_recording("mcap", drive_entries())
    robot = tmp_path / "robot.yaml"
    assert navtool_here("inspect", bag, "--write-robot", robot).code == 0
    options = ("--robot", robot, "--out", tmp_path / "out", "--dry-run", "--json", "robot.width_m=0.7")
    planned = navtool_here("ingest", bag, *options)
    assert planned.code == 0, planned.err
    assert json.loads(planned.out)["recordings"][0]["topics"]["lidar"] == "/points"


def test_a_reason_is_reported_once_for_all_its_recordings(navtool_here: Callable[..., Any], tmp_path: Path) -> None:
    bags = [tmp_path / f"run-{number}.bag" for number in range(7)]
    for bag in bags[:6]:
        bag.write_text("not a recording")
    bags[6].touch()
    told = navtool_here("ingest", tmp_path, "--out", tmp_path / "out")
    assert told.code == 1
    words = " ".join(told.out.split())
    assert words.count("this is not a recording") == 1
    assert words.count("the file is empty") == 1
    assert [str(bag) in words for bag in bags] == [True] * 5 + [False, True]
    assert "and 1 more, see --json" in words
    listed = json.loads(navtool_here("ingest", tmp_path, "--out", tmp_path / "out", "--json").out)["quarantined"]
    assert [entry["path"] for entry in listed] == [str(bag) for bag in bags]


@pytest.fixture
def heeded_interrupts() -> Iterator[None]:
    """A shell's background job ignores SIGINT, and so would the programs that it starts."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("heeded_interrupts")
@pytest.mark.parametrize("workers", ["1", "2"])
def test_an_interrupted_ingest_says_so_and_leaves_nothing_half_written(
    write_recording: Callable[..., Path], drive_entries: Callable[..., Any], tmp_path: Path, workers: str
) -> None:
    bags = [write_recording("mcap", drive_entries(5.0, seed=seed), name=f"run-{seed}") for seed in range(3)]
    out = tmp_path / "out"
    navtool = str(Path(sys.executable).with_name("navtool"))
    command = [navtool, "ingest", *map(str, bags), "--out", str(out), "--workers", workers]
    with subprocess.Popen(command, stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:  # noqa: S603
        staging = out / "navtool" / "staging"
        while process.poll() is None and not staging.exists():
            time.sleep(0.01)
        process.send_signal(signal.SIGINT)
        _, said = process.communicate(timeout=60)
    assert process.returncode == 130
    assert "interrupted" in said
    assert "Traceback" not in said
    assert not staging.exists()
    done = subprocess.run(command, capture_output=True, text=True, check=True)  # noqa: S603
    assert "3 episodes" in done.stdout or "skipped" in done.stderr
    assert len(NavDataset(out).episodes) == 3
