"""What a folder holds, for comparing it with itself later or with another."""

from pathlib import Path

from navtool.base.lineage import file_sha256


def hashes(root: Path) -> dict[str, str]:
    """The SHA-256 of every file but locks, which empty files stand for."""
    files = (path for path in sorted(root.rglob("*")) if path.is_file() and path.name != ".lock")
    return {path.relative_to(root).as_posix(): file_sha256(path) for path in files}
