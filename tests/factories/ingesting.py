"""Ingest with the defaults of whatever a test does not name."""

from pathlib import Path
from typing import Any

from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.ingest.ingest import ingest
from navtool.datasets.ingest.report import IngestReport
from navtool.datasets.robot.config import RobotConfig


def ingested(paths: list[Path], out: Path, **options: Any) -> IngestReport:
    """The report of an ingest; ``robot``, ``config`` and the options of `ingest` may be named."""
    return ingest(paths, out, options.pop("robot", RobotConfig()), options.pop("config", IngestConfig()), **options)
