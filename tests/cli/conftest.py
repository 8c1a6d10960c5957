"""Running the real command line."""

import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest

from navtool.cli.main import main


@dataclass(frozen=True)
class Outcome:
    """What a command left behind."""

    code: int
    out: str
    err: str


@pytest.fixture(scope="session")
def navtool() -> Callable[..., Outcome]:
    """``navtool(*arguments, cwd=None) -> Outcome`` of the installed command in a process of its own."""

    def run(*arguments: object, cwd: Path | None = None) -> Outcome:
        command = [str(Path(sys.executable).with_name("navtool")), *map(str, arguments)]
        environment = os.environ | {"COLUMNS": "160"}
        done = subprocess.run(  # noqa: S603
            command, capture_output=True, text=True, check=False, timeout=600, cwd=cwd, env=environment
        )
        assert "Traceback" not in done.stderr, done.stderr
        return Outcome(done.returncode, done.stdout, done.stderr)

    return run


@pytest.fixture
def navtool_here(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Callable[..., Outcome]:
    """``navtool_here(*arguments) -> Outcome`` of the command in this process, which has loaded all already."""

    def run(*arguments: object) -> Outcome:
        monkeypatch.setattr(sys, "argv", ["navtool", *map(str, arguments)])
        monkeypatch.setenv("COLUMNS", "160")
        with pytest.raises(SystemExit) as left:
            main()
        printed = capsys.readouterr()
        return Outcome(int(left.value.code or 0), printed.out, printed.err)

    return run
