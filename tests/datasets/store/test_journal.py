"""The journalled step: killed at any moment, the files are all old or, once recovered, all new."""

import fcntl
import json
import subprocess
import sys
from pathlib import Path

import pytest

from navtool.base.errors import DatasetsError
from navtool.datasets.store.journal import commit, finish, journal_path, recover, staged

NAMES = ("data/a.parquet", "data/b.parquet", "meta/stats.json", "navtool/labels.json")
KILLED = 9

COMMIT_AND_DIE = f"""
import os, sys
from pathlib import Path
from navtool.datasets.store.journal import commit
root, at = Path(sys.argv[1]), int(sys.argv[2])
commit(root, [root / name for name in sys.argv[3:]], lambda done: os._exit({KILLED}) if done == at else None)
"""


@pytest.fixture
def root(tmp_path: Path) -> Path:
    for name in NAMES[:3]:
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text("old")
    (tmp_path / "navtool").mkdir()
    for name in NAMES:
        staged(tmp_path / name).write_text("new")
    return tmp_path


def contents(root: Path) -> list[str | None]:
    return [(root / name).read_text() if (root / name).exists() else None for name in NAMES]


def leftovers(root: Path) -> list[Path]:
    return [*root.rglob("*.new"), *root.rglob("journal.json")]


def test_a_commit_replaces_every_file_and_leaves_nothing_behind(root: Path) -> None:
    steps: list[int] = []
    commit(root, [root / name for name in NAMES], steps.append)
    assert contents(root) == ["new"] * 4
    assert leftovers(root) == []
    assert steps == [0, 1, 2, 3, 4]


@pytest.mark.parametrize("at", range(5))
def test_a_kill_between_two_steps_is_recovered(root: Path, at: int) -> None:
    command = [sys.executable, "-c", COMMIT_AND_DIE, str(root), str(at), *NAMES]
    assert subprocess.run(command, check=False).returncode == KILLED  # noqa: S603 - our own interpreter and text
    assert contents(root)[at:] == (["old"] * 3 + [None])[at:]
    assert contents(root)[:at] == ["new"] * at
    assert recover(root)
    assert contents(root) == ["new"] * 4
    assert leftovers(root) == []
    assert not recover(root)


def test_stopped_before_the_journal_nothing_has_changed(root: Path) -> None:
    assert not recover(root)
    assert contents(root) == ["old", "old", "old", None]
    assert not finish(root)
    assert leftovers(root) == []
    assert contents(root) == ["old", "old", "old", None]


def test_a_recovery_that_is_killed_too_is_recovered(root: Path) -> None:
    journal_path(root).write_text(json.dumps({"files": list(NAMES)}))
    staged(root / NAMES[0]).replace(root / NAMES[0])
    assert recover(root)
    assert contents(root) == ["new"] * 4


def test_recovery_does_not_wait_for_ever(root: Path) -> None:
    journal_path(root).write_text(json.dumps({"files": list(NAMES)}))
    with (root / "navtool" / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        with pytest.raises(DatasetsError, match="another process is writing"):
            recover(root)
    assert contents(root) == ["old", "old", "old", None]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('{"files": ["data/a.parquet", "../outside"]}', "outside of the data set"),
        ('{"files": []}', "names no files"),
        ("{", "is not JSON"),
    ],
)
def test_a_damaged_or_forged_journal_moves_nothing(root: Path, text: str, said: str) -> None:
    staged(root.parent / "outside").write_text("new")
    journal_path(root).write_text(text)
    with pytest.raises(DatasetsError, match=said):
        recover(root)
    assert contents(root) == ["old", "old", "old", None]
    assert not (root.parent / "outside").exists()


def test_a_missing_staged_file_is_found_before_anything_changes(root: Path) -> None:
    staged(root / NAMES[1]).unlink()
    with pytest.raises(DatasetsError, match="cannot be written"):
        commit(root, [root / name for name in NAMES])
    assert contents(root) == ["old", "old", "old", None]


def test_a_reader_waits_for_a_writer_that_is_about_to_be_done(root: Path) -> None:
    writer = f"""
import sys, time
from pathlib import Path
from navtool.datasets.store.journal import commit
from navtool.datasets.store.layout import Layout
import fcntl
root = Path(sys.argv[1])
with Layout(root).lock.open("w") as lock:
    fcntl.flock(lock, fcntl.LOCK_EX)
    commit(root, [root / name for name in {NAMES!r}], lambda done: time.sleep(0.05))
"""
    with subprocess.Popen([sys.executable, "-c", writer, str(root)]) as process:  # noqa: S603 - our own text
        while not journal_path(root).exists():
            assert process.poll() is None
        assert not recover(root), "the writer has finished its own step"
        assert contents(root) == ["new"] * 4
        assert process.wait(timeout=30) == 0
