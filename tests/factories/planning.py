"""Plans of recordings' episodes: what ingest knows before it reads pictures and clouds."""

from pathlib import Path
from typing import Any

from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.ingest.plan import EpisodePlan, plan_episode
from navtool.datasets.recording import open_recording
from navtool.datasets.robot.config import RobotConfig


def planned(path: Path, robot: RobotConfig | None = None, **settings: Any) -> EpisodePlan:
    """The plan of a recording by itself; settings are those of ingest."""
    with open_recording(path) as recording:
        return plan_episode(recording, robot or RobotConfig(), IngestConfig(**settings), None)
