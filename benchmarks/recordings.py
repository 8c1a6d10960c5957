"""Writes docs/recordings.md: what ingest makes of every real recording at hand, or why it makes nothing."""

import os
import sys
import tempfile
from pathlib import Path
from typing import Any

from navtool.datasets.errors import DatasetsError
from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.ingest.ingest import ingest
from navtool.datasets.ingest.natural import expand
from navtool.datasets.inspect import inspect_recording
from navtool.datasets.robot import RobotConfig

ROOT = Path(__file__).resolve().parents[1]
FOLDERS = ("bags", "lidar/nebula_vlp16")
HEAD = """# Real recordings

What `navtool ingest` makes of real recordings of many labs, each by itself, without a robot file: every one gives a
data set or the reason why not. Written by `python benchmarks/recordings.py` where `NAVTOOL_DATA` names the recordings.

| recording | container | messages | streams, messages at Hz | rows | messages without a row | or why there is none |
|---|---|---|---|---|---|---|
"""


def main() -> None:
    data = Path(os.environ.get("NAVTOOL_DATA", ROOT.parent / "shared" / "data"))
    if not data.is_dir():
        sys.exit(f"no recordings at {data}; set NAVTOOL_DATA to their folder")
    paths = [path for folder in FOLDERS for path in expand([data / folder])]
    lines = [row(path, path.relative_to(data).as_posix()) for path in paths]
    page = ROOT / "docs" / "recordings.md"
    page.write_text(HEAD + "\n".join(lines) + "\n", encoding="utf-8")
    print(f"{len(lines)} recordings -> {page}")


def row(path: Path, name: str) -> str:
    """One recording's line of the table."""
    try:
        seen = inspect_recording(path)
    except DatasetsError as error:
        return f"| `{name}` | | | | | | {cell(error.what)} |"
    with tempfile.TemporaryDirectory() as folder:
        report = ingest([path], Path(folder) / "out", RobotConfig(), IngestConfig())
    container, messages = seen.format, seen.messages
    if not report.episodes:
        reason = report.quarantined[0].reason
        return f"| `{name}` | {container} | {messages} | | | | {cell(reason)} |"
    (episode,) = report.episodes
    streams = ", ".join(stream(key, value) for key, value in episode.sync["streams"].items())
    dropped = ", ".join(f"{reason}: {count}" for reason, count in episode.dropped.items())
    return f"| `{name}` | {container} | {messages} | {streams} | {episode.rows} | {cell(dropped)} | |"


def stream(name: str, told: dict[str, Any]) -> str:
    rate = "" if told["rate_hz"] is None else f" at {told['rate_hz']:.1f}"
    return f"{name} `{told['topic']}` {told['messages']}{rate}"


def cell(text: str) -> str:
    flat = " ".join(text.split()).replace("|", "/")
    return flat if len(flat) <= 300 else f"{flat[:297]}..."


if __name__ == "__main__":
    main()
