"""Notes: their codes are written once and listed; files show their text alone."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

from navtool.base.note import Note
from navtool.base.plain import plain

ROOT = Path(__file__).parents[2]
PACKAGES = ("base", "cli", "configs", "datasets", "export", "methods", "pipeline", "sim", "train")


def made() -> Iterator[str]:
    """The code of every note that the product makes, as often as it is written: several notes share one by its name."""
    files = [path for package in PACKAGES for path in (ROOT / package).rglob("*.py")]
    trees = {path: ast.parse(path.read_text(encoding="utf-8")) for path in files}
    codes = [
        code for path, tree in trees.items() if path != ROOT / "base" / "note.py" for code in first_arguments(tree)
    ]
    yield from (str(code.value) for code in codes if isinstance(code, ast.Constant))
    shared = {code.id for code in codes if isinstance(code, ast.Name)}
    for node in (node for tree in trees.values() for node in tree.body):
        if isinstance(node, ast.Assign) and isinstance(node.value, ast.Constant):
            names = {name.id for name in node.targets if isinstance(name, ast.Name)}
            yield from (str(node.value.value) for _ in names & shared)


def first_arguments(tree: ast.Module) -> Iterator[ast.expr]:
    """What stands for the code where a note is made; of two that depend on something, both."""
    for call in ast.walk(tree):
        if isinstance(call, ast.Call) and isinstance(call.func, ast.Name) and call.func.id == "Note":
            code = call.args[0]
            yield from (code.body, code.orelse) if isinstance(code, ast.IfExp) else (code,)


def test_every_code_is_written_once_and_listed() -> None:
    codes = sorted(made())
    listed = re.findall(r"(?m)^\| `([a-z.-]+)` \|", (ROOT / "docs" / "notes.md").read_text(encoding="utf-8"))
    assert codes == sorted(listed)
    assert len(codes) == len(set(codes))
    assert all(re.fullmatch(r"[a-z]+\.[a-z-]+", code) for code in codes)


def test_it_is_shown_by_its_text() -> None:
    note = Note("clock.late", "late").about("imu")
    assert (note.code, str(note)) == ("clock.late", "imu: late")
    assert plain({"notes": [note]}) == {"notes": ["imu: late"]}
