"""Notes: their codes are each used for one thing, and listed; files show their text alone."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

from navtool.base.note import Note
from navtool.base.plain import plain

ROOT = Path(__file__).parents[2]
PACKAGES = ("base", "cli", "configs", "datasets", "export", "methods", "pipeline", "sim", "train")


def made() -> Iterator[str]:
    """The code of every note that the product makes, as often as it stands in it."""
    for path in (path for package in PACKAGES for path in (ROOT / package).rglob("*.py")):
        for call in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(call, ast.Call) and isinstance(call.func, ast.Name) and call.func.id == "Note":
                code = call.args[0]
                if path != ROOT / "base" / "note.py":
                    assert isinstance(code, ast.Constant), f"{path}:{call.lineno}: a code is written where it arises"
                    yield str(code.value)


def test_every_code_is_of_one_note_and_listed() -> None:
    codes = sorted(made())
    listed = re.findall(r"(?m)^\| `([a-z.-]+)` \|", (ROOT / "docs" / "notes.md").read_text(encoding="utf-8"))
    assert codes == sorted(listed)
    assert len(codes) == len(set(codes))
    assert all(re.fullmatch(r"[a-z]+\.[a-z-]+", code) for code in codes)


def test_it_is_shown_by_its_text() -> None:
    note = Note("clock.late", "late").about("imu")
    assert (note.code, str(note)) == ("clock.late", "imu: late")
    assert plain({"notes": [note]}) == {"notes": ["imu: late"]}
