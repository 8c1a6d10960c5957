"""The folder of an output is there whole, or not at all; what is something else's is refused."""

from dataclasses import dataclass
from pathlib import Path

import pytest

from navtool.base.errors import DatasetsError, OutputError
from navtool.base.output_folder import LINEAGE, OutputFolder

IDENTITY = {"input": "a" * 64, "settings": "b" * 64, "code_version": "0.1.0+src.1", "laps": 3}

KIND = "navtool intensity maps"


@dataclass
class Report:
    maps: int
    out: str = ""
    seconds: float = 0.0


def folder_at(out: Path, **changed: object) -> OutputFolder:
    return OutputFolder(out, KIND, {**IDENTITY, **changed})


def make(out: Path, maps: int = 3, *, replace: bool = False) -> None:
    folder = folder_at(out)
    with folder.staged(replace=replace) as staging:
        folder.write_record(staging, {"recording": "/bags/a.mcap"}, Report(maps, "elsewhere", 2.5))
        (staging / f"map-{maps}").touch()


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def test_it_is_there_when_it_is_left(tmp_path: Path) -> None:
    out = tmp_path / "deep" / "maps"
    make(out)
    assert folder_at(out).finished(Report) == Report(3, out.as_posix())
    assert names(out.parent) == ["maps"]
    assert names(out) == [LINEAGE, "map-3"]
    folder_at(out).refuse_other()


def test_an_empty_folder_is_taken(tmp_path: Path) -> None:
    (tmp_path / "maps").mkdir()
    folder_at(tmp_path / "maps").refuse_other()
    make(tmp_path / "maps")
    assert folder_at(tmp_path / "maps").finished(Report) is not None


def test_nothing_is_there_before_it_is_left(tmp_path: Path) -> None:
    with folder_at(tmp_path / "maps").staged() as staging:
        assert not (tmp_path / "maps").exists()
        assert staging.parent == tmp_path


def test_what_fails_leaves_nothing(tmp_path: Path) -> None:
    def fail() -> None:
        with folder_at(tmp_path / "maps").staged() as staging:
            (staging / "half").touch()
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fail()
    assert not list(tmp_path.iterdir())


def test_what_a_killed_run_left_is_replaced(tmp_path: Path) -> None:
    staging = tmp_path / ".maps.unfinished"
    staging.mkdir()
    (staging / "half").touch()
    assert folder_at(tmp_path / "maps").finished(Report) is None
    make(tmp_path / "maps")
    assert names(tmp_path) == ["maps"]
    assert names(tmp_path / "maps") == [LINEAGE, "map-3"]


def test_an_output_goes_only_where_it_is_to_be_replaced(tmp_path: Path) -> None:
    out = tmp_path / "maps"
    make(out)
    with pytest.raises(OutputError, match="cannot be written"):
        make(out, 4)
    assert names(out) == [LINEAGE, "map-3"]
    make(out, 4, replace=True)
    assert names(out) == [LINEAGE, "map-4"]
    assert names(tmp_path) == ["maps"]


def test_an_output_that_a_killed_run_moved_aside_comes_back(tmp_path: Path) -> None:
    out = tmp_path / "maps"
    make(out)
    out.rename(tmp_path / ".maps.replaced")

    def fail() -> None:
        with folder_at(out).staged(replace=True):
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fail()
    assert names(tmp_path) == ["maps"]
    assert names(out) == [LINEAGE, "map-3"]


def test_another_output_is_refused_with_what_differs(tmp_path: Path) -> None:
    make(tmp_path / "maps")
    with pytest.raises(DatasetsError, match="made with another settings, code version") as caught:
        folder_at(tmp_path / "maps", settings="x" * 64, code_version="0.1.0+src.2").finished(Report)
    assert "code version (was 0.1.0+src.1, now 0.1.0+src.2)" in str(caught.value)
    assert "--out" in str(caught.value)


def test_many_differences_are_counted(tmp_path: Path) -> None:
    folder = OutputFolder(tmp_path, identity={f"camera.{name}": 1 for name in "abcdef"})
    with pytest.raises(DatasetsError, match=r"camera\.a \(was 2, now 1\), .* and 2 more"):
        folder.refuse_differing({f"camera.{name}": 2 for name in "abcdef"})
    with pytest.raises(DatasetsError, match=r"another g \(was 1, now None\)"):
        folder.refuse_differing({**folder.identity, "g": 1})
    folder.refuse_differing(dict(folder.identity))


def test_something_else_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(DatasetsError, match="is a file"):
        folder_at(tmp_path / "file").refuse_other()
    with pytest.raises(DatasetsError, match=r"something else \(file\)"):
        folder_at(tmp_path).refuse_other()
    (tmp_path / LINEAGE).write_text('{"kind": "a family tree"}')
    with pytest.raises(DatasetsError, match="something else"):
        folder_at(tmp_path).refuse_other()
    OutputFolder(tmp_path, record=LINEAGE).refuse_other()  # a record that nobody else has, whatever it says


def test_two_do_not_write_at_once(tmp_path: Path) -> None:
    out = tmp_path / "maps"
    with folder_at(out).staged(), pytest.raises(DatasetsError, match="another process is writing"):
        make(out)
    with OutputFolder(out).held(lambda: False), pytest.raises(DatasetsError, match="another process is writing"):
        OutputFolder(out).held(lambda: False).__enter__()


def test_a_folder_that_cannot_be_made_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(OutputError, match="maps: cannot be written"):
        make(tmp_path / "file" / "maps")


def test_an_output_that_grows_is_gone_where_nothing_came_of_it(tmp_path: Path) -> None:
    folder = OutputFolder(tmp_path / "deep" / "runs", record="runs.json")
    for _ in range(2):
        with folder.held(lambda: True):
            (folder.root / "half").touch()
        assert not folder.root.exists()
    with folder.held(lambda: False):
        (folder.root / "runs.json").touch()
    with folder.held(lambda: True):  # it was there before: whatever is in it stays
        (folder.root / "a").touch()
    assert names(folder.root) == [".lock", "a", "runs.json"]


def test_a_lock_that_a_killed_run_left_holds_nobody(tmp_path: Path) -> None:
    (tmp_path / "runs").mkdir()
    (tmp_path / "runs" / ".lock").touch()
    folder = OutputFolder(tmp_path / "runs", record="runs.json")
    with folder.held(lambda: False):
        (folder.root / "runs.json").touch()
    folder.refuse_other()
