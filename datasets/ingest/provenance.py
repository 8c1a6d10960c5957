"""What an episode was made from, and with which settings."""

from pathlib import Path

from navtool.base.lineage import code_version
from navtool.base.plain import plain_fields
from navtool.datasets.ingest.config import PARENT, IngestConfig
from navtool.datasets.ingest.plan import EpisodePlan
from navtool.datasets.ingest.plan_step import Planned
from navtool.datasets.ingest.settings import settings_hash
from navtool.datasets.recording.identity import absolute, source_name
from navtool.datasets.robot.config import RobotConfig
from navtool.datasets.store.description import Description


def provenance_of(path: Path, planned: Planned, robot: RobotConfig, config: IngestConfig) -> dict[str, object]:
    """The content of an episode's ``provenance.json``, but for the hash of its video."""
    plan = planned.plan
    return {
        "source": source_name(path),
        "sha256": planned.sha256,
        "bytes": planned.size,
        "place": place_of(path, config),
        "recording_start_ns": plan.recording_start_ns,
        "start_ns": int(plan.ticks_ns[0]),
        "end_ns": int(plan.ticks_ns[-1]),
        "recovered": list(plan.faults),
        "topics": dict(plan.topics.streams),
        "not_used": [plain_fields(topic) for topic in plan.topics.not_used],
        "config_hash": settings_hash(robot, config),
        "code_version": code_version(),
    }


def description_of(plan: EpisodePlan, robot: RobotConfig, config: IngestConfig) -> Description:
    """The data set that an episode of this plan is or would be the first of."""
    return Description(
        fps=config.fps,
        contents=plan.contents,
        robot=plain_fields(robot),
        ingest=plain_fields(config),
        config_hash=settings_hash(robot, config),
    )


def place_of(path: Path, config: IngestConfig) -> str:
    """Where a recording was made, as the settings say: its folder is named as it was reached."""
    return absolute(path).parent.name if config.place == PARENT else config.place
