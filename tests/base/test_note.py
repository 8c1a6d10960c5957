"""Notes: their codes are listed, each once; files show their text alone."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

from navtool.base.note import Note
from navtool.base.plain import plain

ROOT = Path(__file__).parents[2]
PACKAGES = ("base", "cli", "configs", "datasets", "export", "methods", "pipeline", "sim", "train")


def made() -> Iterator[str]:
    """The code of every note that the product makes, as often as it stands in it; one that notes share has a name."""
    for path in (path for package in PACKAGES for path in (ROOT / package).rglob("*.py")):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        calls = [node for node in ast.walk(tree) if isinstance(node, ast.Call)]
        notes = [call for call in calls if isinstance(call.func, ast.Name) and call.func.id == "Note"]
        codes = [call.args[0] for call in notes if path != ROOT / "base" / "note.py"]
        either = [
            part for code in codes for part in ((code.body, code.orelse) if isinstance(code, ast.IfExp) else (code,))
        ]
        yield from (str(code.value) for code in either if isinstance(code, ast.Constant))
        shared = {code.id for code in codes if isinstance(code, ast.Name)}
        for node in tree.body:
            if isinstance(node, ast.Assign) and isinstance(node.value, ast.Constant):
                yield from (
                    str(node.value.value) for name in node.targets if isinstance(name, ast.Name) and name.id in shared
                )


def test_every_code_is_listed_once_and_only_those() -> None:
    codes = set(made())
    listed = re.findall(r"(?m)^\| `([a-z.-]+)` \|", (ROOT / "docs" / "notes.md").read_text(encoding="utf-8"))
    assert sorted(codes) == sorted(listed)
    assert all(re.fullmatch(r"[a-z]+\.[a-z-]+", code) for code in codes)


def test_it_is_shown_by_its_text() -> None:
    note = Note("clock.late", "late").about("imu")
    assert (note.code, str(note)) == ("clock.late", "imu: late")
    assert plain({"notes": [note]}) == {"notes": ["imu: late"]}
