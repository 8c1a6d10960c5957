"""``navtool simulate`` from outside: its output, its errors, and what is left when it is ended."""

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import cv2
import pytest
from hashes import hashes

from navtool.base.lineage import file_sha256
from navtool.cli.main import main

PLACE = (
    "scenario=demo",
    "scenario.side_m=20",
    "scenario.course_m=10",
    "scenario.cell_m=0.25",
    "scenario.trees.count=2",
)
SENSORS = ("camera.width=64", "camera.height=48", "lidar.elevation_rad=[-0.1]", "lidar.firing_order=[0]")
SMALL = (*PLACE, *SENSORS, "drive.duration_s=2")


def test_recordings_a_sheet_and_a_report_come_out(navtool_here: Callable[..., Any], tmp_path: Path) -> None:
    out, sheet = tmp_path / "out", tmp_path / "sheet.png"
    done = navtool_here("simulate", *SMALL, "--out", out, "--preview", sheet, "--json")
    assert done.code == 0, done.err
    report = json.loads(done.out)
    assert report["minutes"] == pytest.approx(2 / 60, abs=1e-3)
    (episode,) = report["episodes"]
    assert file_sha256(out / episode["plan"]["path"]) == episode["sha256"]
    picture = cv2.imread(str(sheet))
    assert picture is not None
    assert picture.shape[1] > 1000
    again = navtool_here("simulate", *SMALL, "--out", out)
    assert again.code == 0
    assert "1 episodes were there already" in again.err
    other = navtool_here("simulate", *SMALL, "camera.width=80", "--out", out)
    assert other.code == 2
    assert "camera.width (was 64, now 80)" in other.err


def test_bad_calls_get_one_error_and_an_exit_code(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    (tmp_path / "file").touch()
    cases: list[tuple[list[object], int, str]] = [
        ([], 2, "--out"),
        (["--out", tmp_path / "file"], 2, "is a file"),
        (["--out", tmp_path], 2, "holds something else (file)"),
        (["scenario=grapse_1", "--out", out], 2, "did you mean graspe_1?"),
        (["scenario=grapse_1", "--out", out], 2, "amco_1, amco_2"),
        (
            ["scenario.weather.rain_mmph=500", "--out", out],
            2,
            "rain_mmph: 500 mm/h is outside [0, 100] mm/h",
        ),
        (["robot=hexapod", "--out", out], 2, "wheeled"),
        (["gait=gallop", "--out", out], 2, "amble"),
        (["format=bag", "--out", out], 2, "ros1"),
        (["camera.width=8", "--out", out], 2, "camera.width: 8 px is outside"),
        (["drive.duration_s=0", "--out", out], 2, "duration_s: 0 s"),
        (["camera.colour=red", "--out", out], 2, "colour"),
        (["--preview", tmp_path / "sheet.jpg", "--out", out], 2, ".png"),
        (["--episodes", "0", "--out", out], 2, "--episodes"),
        (["--episodes", "20000", "--out", out], 1, "10000 episodes"),
    ]
    for arguments, code, said in cases:
        monkeypatch.setattr(sys, "argv", ["navtool", "simulate", *map(str, arguments)])
        with pytest.raises(SystemExit) as left:
            main()
        printed = capsys.readouterr()
        assert left.value.code == code, (arguments, printed)
        assert said in printed.err + printed.out, (arguments, printed)
        assert not out.exists(), arguments


@pytest.mark.parametrize("missing", ["embreex", "mujoco"])
def test_without_the_extra_the_cure_is_reported(missing: str, tmp_path: Path) -> None:
    call = ["navtool", "simulate", *SMALL, "robot=quadruped", "--out", str(tmp_path / "out")]
    code = (
        f"import sys; sys.modules[{missing!r}] = None; sys.argv = {call!r}; from navtool.cli.main import main; main()"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)  # noqa: S603
    assert done.returncode == 1
    assert f"{missing} is not installed" in done.stderr
    assert "pip install 'navtool[sim]'" in done.stderr
    assert "Traceback" not in done.stderr
    assert not (tmp_path / "out").exists()


def test_the_configuration_is_printed_without_the_extra() -> None:
    call = ["navtool", "simulate", "scenario=mim_2", "robot=quadruped", "--cfg", "job"]
    heavy = ("embreex", "mujoco", "torch")
    code = (
        f"import sys; sys.modules |= dict.fromkeys({heavy}); sys.argv = {call!r}\n"
        "from navtool.cli.main import main; main()"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)  # noqa: S603
    assert "partition: curtain" in done.stdout
    assert "robot: quadruped" in done.stdout


@pytest.fixture
def heeded_interrupts() -> Iterator[None]:
    """A shell's background job ignores SIGINT, and so would the programs that it starts."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.slow
@pytest.mark.usefixtures("heeded_interrupts")
@pytest.mark.parametrize("workers", ["1", "2"])
@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGKILL], ids=["interrupted", "killed"])
def test_an_ended_run_leaves_whole_recordings_and_goes_on(
    how: signal.Signals, workers: str, navtool: Callable[..., Any], tmp_path: Path
) -> None:
    arguments = ["simulate", *SMALL, "drive.duration_s=6", "--episodes", "4", "--workers"]
    whole, out = tmp_path / "whole", tmp_path / "out"
    assert navtool(*arguments, "2", "--out", whole).code == 0
    command = [str(Path(sys.executable).with_name("navtool")), *arguments, workers, "--out", str(out)]
    with subprocess.Popen(  # noqa: S603
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
    ) as process:
        while process.poll() is None and not (list(out.glob("*/*.mcap")) and list(out.glob(".unfinished/*"))):
            time.sleep(0.01)
        os.killpg(process.pid, how)
        _, said = process.communicate(timeout=120)
    if how is signal.SIGINT:
        assert process.returncode == 130
        assert said.strip().splitlines()[-1].startswith("error: interrupted;")
        assert not (out / ".unfinished").exists()
    made = {path.relative_to(out).as_posix(): file_sha256(path) for path in out.glob("*/*.mcap")}
    assert made.items() <= hashes(whole).items()
    assert 0 < len(made) < 4
    assert navtool(*arguments, workers, "--out", out).code == 0
    assert hashes(out) == hashes(whole)
