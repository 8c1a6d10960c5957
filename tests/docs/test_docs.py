"""What the docs name is there: modules and what they define, files, tests, and the ends of links."""

import ast
import re
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
FOLDERS = ("base", "benchmarks", "cli", "configs", "datasets", "export", "methods", "pipeline", "sim", "train")
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", ROOT / "CHANGELOG.md", *sorted((ROOT / "docs").rglob("*.md"))]

_CODE = re.compile(r"`([^`\n]+)`")
_FENCE = re.compile(r"^ *```.*?^ *```", re.MULTILINE | re.DOTALL)
_IMPORT = re.compile(r"^ *from (navtool[\w.]+) import (.+)$|^ *import (navtool[\w.]+)$", re.MULTILINE)
_TEST = re.compile(r"^(?:[\w./]+/)?(?:test_\w+\.py)?(?:\.\.)?(?:::test_\w+)?$")
_LINK = re.compile(r"\]\(([^)\s]+)\)")
_FILE = re.compile(rf"^(?:{'|'.join((*FOLDERS, 'docs', 'tests'))})/[\w./-]*\w(?=$|::)")
_DOTTED = re.compile(rf"^(?:navtool|{'|'.join(FOLDERS)})(?:\.\w+)+(?=$|\()")


@cache
def defined(source: Path) -> dict[str, frozenset[str]]:
    """What a module defines, by name, each with the names of its own body (of a class)."""
    found: dict[str, frozenset[str]] = {}
    for node in ast.parse(source.read_text()).body:
        found |= dict.fromkeys(names_of(node), frozenset())
        if isinstance(node, ast.ClassDef):
            found[node.name] = frozenset(name for entry in node.body for name in names_of(entry))
    return found


def names_of(node: ast.stmt) -> list[str]:
    """The names that a statement binds, imported ones among them."""
    if isinstance(node, ast.ClassDef | ast.FunctionDef):
        return [node.name]
    if isinstance(node, ast.ImportFrom | ast.Import):
        return [entry.asname or entry.name for entry in node.names]
    if isinstance(node, ast.Assign):
        return [target.id for target in node.targets if isinstance(target, ast.Name)]
    return [node.target.id] if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name) else []


def is_there(dotted: str) -> bool:
    """Whether ``train.success.windows.Windows.history`` and the like name a package, a module or something in one."""
    parts = dotted.removeprefix("navtool.").split(".")
    for length in range(len(parts), 0, -1):
        path = ROOT.joinpath(*parts[:length])
        rest = parts[length:]
        if path.is_dir() and not rest:
            return True
        source = path.with_suffix(".py") if path.with_suffix(".py").is_file() else path / "__init__.py"
        if source.is_file():
            return not rest or is_defined(defined(source), rest)
    return False


def is_defined(names: dict[str, frozenset[str]], rest: list[str]) -> bool:
    """Whether a module has a name, or a class of it has a member."""
    return rest[0] in names and (len(rest) == 1 or rest[1] in names[rest[0]])


@cache
def modules() -> dict[str, list[Path]]:
    """The product's modules by their own name."""
    found: dict[str, list[Path]] = {}
    for path in (path for folder in FOLDERS for path in (ROOT / folder).rglob("*.py")):
        found.setdefault(path.stem, []).append(path)
    return found


@cache
def files_of_tests() -> dict[str, list[Path]]:
    """Test files by name."""
    found: dict[str, list[Path]] = {}
    for path in (ROOT / "tests").rglob("test_*.py"):
        found.setdefault(path.name, []).append(path)
    return found


def missing_test(code: str) -> bool:
    """Whether ``test_x.py::test_y`` or ``..::test_y`` names a test that is not there."""
    file, _, test = code.partition("::")
    name = file.rpartition("/")[2]
    if name.startswith("test_") and name not in files_of_tests():
        return True
    if not test:
        return False
    sources = files_of_tests().get(name) or [path for paths in files_of_tests().values() for path in paths]
    return not any(re.search(rf"def {test.partition('[')[0]}\(", path.read_text()) for path in sources)


def anchors(page: Path) -> set[str]:
    """The anchors of a page's headings, as forges make them."""
    headings = re.findall(r"^#+ (.+)$", _FENCE.sub("", page.read_text()), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


def absent(page: Path) -> list[str]:
    """Everything that a page names and that is not there."""
    text = page.read_text()
    prose = _FENCE.sub("", text)
    faults = []
    for code in _CODE.findall(prose):
        if "NAME" in code:
            continue
        file, dotted = _FILE.match(code), _DOTTED.match(code)
        if file and not (ROOT / file[0]).exists() and not ignored(file[0]):
            faults.append(f"no file {file[0]}")
        if dotted and not is_there(dotted[0]):
            faults.append(f"no name {dotted[0]}")
        if _TEST.match(code) and missing_test(code):
            faults.append(f"no test {code}")
    for module, names, whole in _IMPORT.findall(text):
        wanted = [f"{module}.{name.split(' as ')[0].strip()}" for name in names.split(",")] if module else [whole]
        faults += [f"no name {dotted}" for dotted in wanted if not is_there(dotted)]
    for link in _LINK.findall(prose):
        target, _, anchor = link.partition("#")
        file_there = (page.parent / target).resolve() if target else page
        if "://" not in link and not (file_there.exists() and (not anchor or anchor in anchors(file_there))):
            faults.append(f"no end of the link {link}")
    return faults


def ignored(path: str) -> bool:
    """Whether a path is something that a command makes and git ignores."""
    return path.startswith("benchmarks/out")


def test_the_functions_of_the_papers_are_there() -> None:
    text = (ROOT / "docs" / "papers.md").read_text()
    short = [code.split(".") for code in _CODE.findall(text) if re.fullmatch(r"(?!label\.)[a-z_]+\.\w+", code)]
    named = [(module, name) for module, name in short if module in modules()]
    assert len(named) > 20
    missing = [pair for pair in named if not any(pair[1] in defined(path) for path in modules()[pair[0]])]
    assert missing == []


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_everything_that_a_page_names_is_there(page: Path) -> None:
    assert absent(page) == []


def test_what_is_not_there_is_found(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text(
        "# One heading\n`train/nowhere.py` `navtool.train.success.windows.Nowhere`\n"
        "`train.success.windows.Windows.nowhere`\n"
        "`tests/train/test_nowhere.py` `test_windows.py::test_nowhere` [a](nowhere.md) [b](#another)\n"
        "```\nfrom navtool.train.success.windows import Windows, Nowhere\n```\n"
        "`navtool.train.success.windows.Windows` [c](#one-heading) `train/success/windows.py` `test_windows.py`\n"
    )
    assert absent(page) == [
        "no file train/nowhere.py",
        "no name navtool.train.success.windows.Nowhere",
        "no name train.success.windows.Windows.nowhere",
        "no file tests/train/test_nowhere.py",
        "no test tests/train/test_nowhere.py",
        "no test test_windows.py::test_nowhere",
        "no name navtool.train.success.windows.Nowhere",
        "no end of the link nowhere.md",
        "no end of the link #another",
    ]


def test_the_door_is_short() -> None:
    assert len((ROOT / "README.md").read_text().splitlines()) < 160
