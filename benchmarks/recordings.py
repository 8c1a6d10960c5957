"""Writes docs/recordings.md: what ingest makes of every real recording at hand, or why it makes nothing."""

import os
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

from navtool.base.errors import DatasetsError
from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.ingest.ingest import ingest
from navtool.datasets.ingest.natural import expand
from navtool.datasets.ingest.plan import plan_episode
from navtool.datasets.ingest.report import EpisodeSummary
from navtool.datasets.inspect.inspection import Inspection, inspect_recording
from navtool.datasets.recording import open_recording
from navtool.datasets.robot.config import RobotConfig

ROOT = Path(__file__).resolve().parents[1]
FOLDERS = ("bags", "lidar/nebula_vlp16")
HEAD = """# Real recordings

What `navtool ingest` makes of real recordings of many labs, each by itself, without a robot file: every one gives a
data set or the reason why not. Written by `python benchmarks/recordings.py` where `NAVTOOL_DATA` names the recordings.
What of a recording is read and believed, and what is noted, says [ingest.md](ingest.md).

| recording | container | messages | streams, messages at Hz | rows | messages without a row | or why there is none |
|---|---|---|---|---|---|---|
"""
NOT_USED = "not used: "
"""How a refusal goes on to the topics that have a list of their own here."""


@dataclass(frozen=True)
class Outcome:
    """What became of one recording."""

    name: str
    seen: Inspection | None
    """None where it cannot be read at all."""
    episode: EpisodeSummary | None
    refusal: DatasetsError | None
    """Why there is no episode."""


def main() -> None:
    data = Path(os.environ.get("NAVTOOL_DATA", ROOT.parent / "shared" / "data"))
    if not data.is_dir():
        sys.exit(f"no recordings at {data}; set NAVTOOL_DATA to their folder")
    paths = [path for folder in FOLDERS for path in expand([data / folder])]
    outcomes = [outcome(path, path.relative_to(data).as_posix()) for path in paths]
    page = ROOT / "docs" / "recordings.md"
    page.write_text(HEAD + "\n".join([*rows(outcomes), *reasons(outcomes), *unused(outcomes)]) + "\n", encoding="utf-8")
    print(f"{len(outcomes)} recordings -> {page}")


def outcome(path: Path, name: str) -> Outcome:
    seen = None
    try:
        seen = inspect_recording(path)
        with open_recording(path) as recording:
            plan_episode(recording, RobotConfig(), IngestConfig(), None)
    except DatasetsError as error:
        return Outcome(name, seen, None, error)
    with tempfile.TemporaryDirectory() as folder:
        report = ingest([path], Path(folder) / "out", RobotConfig(), IngestConfig())
    if not report.episodes:
        return Outcome(name, seen, None, DatasetsError(report.quarantined[0].reason))
    return Outcome(name, seen, report.episodes[0], None)


def rows(outcomes: list[Outcome]) -> list[str]:
    """The table; reasons are numbered as `reasons` lists them."""
    lines, number = [], 0
    for found in outcomes:
        cells = [f"`{found.name}`", *(["", "", ""] if found.seen is None else summary(found.seen))]
        if found.episode is not None:
            dropped = ", ".join(f"{reason}: {count}" for reason, count in found.episode.dropped.items())
            cells += [str(found.episode.rows), dropped, ""]
        elif found.refusal is not None:
            number += 1
            cells += ["", "", f"{number}. {short(found.refusal)}"]
        lines.append(f"| {' | '.join(flat(cell) for cell in cells)} |")
    return lines


def summary(seen: Inspection) -> list[str]:
    """Container, messages, and the streams with their messages and rates."""
    topics = {topic.name: topic for topic in seen.topics if topic.count}
    streams = []
    for stream, name in seen.topic_map.streams.items():
        rate = topics[name].rate_hz
        streams.append(f"{stream} `{name}` {topics[name].count}" + ("" if rate is None else f" at {rate:.1f}"))
    return [seen.format, str(seen.messages), ", ".join(streams)]


def short(refusal: DatasetsError) -> str:
    return refusal.what.partition(NOT_USED)[0].rstrip("; :")


def reasons(outcomes: list[Outcome]) -> list[str]:
    """Every reason whole, with its cure; the topics that are not used have a list of their own."""
    lines = ["", "## Why there is no data set", ""]
    for number, found in enumerate((x for x in outcomes if x.refusal is not None), start=1):
        if found.refusal is not None:
            faults = found.seen.faults if found.seen is not None and NOT_USED in found.refusal.what else ()
            whole = "; ".join([short(found.refusal), *faults])
            cure = f". Cure: {found.refusal.cure}" if found.refusal.cure else ""
            lines.append(flat(f"{number}. `{found.name}`: {whole}{cure}."))
    return lines


def unused(outcomes: list[Outcome]) -> list[str]:
    """Every topic that feeds no stream, by recording and reason."""
    lines = ["", "## Topics that are not used, and why"]
    for found in outcomes:
        left = () if found.seen is None else found.seen.topic_map.not_used
        by_reason: dict[str, list[str]] = {}
        for topic in left:
            by_reason.setdefault(topic.reason, []).append(f"`{topic.name}` ({topic.type})")
        if by_reason:
            lines += ["", f"`{found.name}`", ""]
            lines += [flat(f"- {', '.join(names)}: {reason}") for reason, names in by_reason.items()]
    return lines


def flat(text: str) -> str:
    return " ".join(text.split()).replace("|", "/")


if __name__ == "__main__":
    main()
