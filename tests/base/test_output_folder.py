"""The folder of maps is there whole, or not at all; what is something else's is refused."""

from dataclasses import dataclass
from pathlib import Path

import pytest

from navtool.base.errors import DatasetsError
from navtool.base.files import write_json
from navtool.base.output_folder import (
    LINEAGE,
    finished,
    lineage_content,
    refuse_other_output,
    staged_output,
)

IDENTITY = {"input": "a", "settings": "b", "code_version": "c"}

KIND = "navtool intensity maps"


@dataclass
class Told:
    maps: int


def make(out: Path) -> None:
    with staged_output(out) as staging:
        write_json(staging / LINEAGE, {**lineage_content(KIND, IDENTITY, {}), "report": {"maps": 3, "maps_per_s": 2.5}})
        assert not out.exists() or not any(out.iterdir())


def test_it_is_there_when_it_is_left(tmp_path: Path) -> None:
    out = tmp_path / "deep" / "maps"
    make(out)
    assert finished(out, IDENTITY, Told) == Told(3)
    assert [path.name for path in out.parent.iterdir()] == ["maps"]
    refuse_other_output(out, KIND)


def test_an_empty_folder_is_taken(tmp_path: Path) -> None:
    (tmp_path / "maps").mkdir()
    make(tmp_path / "maps")
    assert finished(tmp_path / "maps", IDENTITY, Told) is not None


def test_what_fails_leaves_nothing(tmp_path: Path) -> None:
    def fail() -> None:
        with staged_output(tmp_path / "maps") as staging:
            (staging / "half").touch()
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fail()
    assert not list(tmp_path.iterdir())


def test_what_a_killed_run_left_is_replaced(tmp_path: Path) -> None:
    staging = tmp_path / ".maps.unfinished"
    staging.mkdir()
    (staging / "half").touch()
    assert finished(tmp_path / "maps", IDENTITY, Told) is None
    make(tmp_path / "maps")
    assert [path.name for path in (tmp_path / "maps").iterdir()] == [LINEAGE]


def test_other_maps_are_refused_with_what_differs(tmp_path: Path) -> None:
    make(tmp_path / "maps")
    with pytest.raises(DatasetsError, match="made with another settings, code version"):
        finished(tmp_path / "maps", {**IDENTITY, "settings": "x", "code_version": "y"}, Told)


def test_something_else_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(DatasetsError, match="is a file"):
        refuse_other_output(tmp_path / "file", KIND)
    with pytest.raises(DatasetsError, match="something else"):
        refuse_other_output(tmp_path, KIND)
    (tmp_path / LINEAGE).write_text('{"kind": "a family tree"}')
    with pytest.raises(DatasetsError, match="something else"):
        refuse_other_output(tmp_path, KIND)


def test_two_do_not_write_at_once(tmp_path: Path) -> None:
    with staged_output(tmp_path / "maps"), pytest.raises(DatasetsError, match="another process is writing"):
        make(tmp_path / "maps")
