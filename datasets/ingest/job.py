"""What every recording of a command is treated with."""

from dataclasses import dataclass

from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.ingest.settings import settings_hash
from navtool.datasets.robot.config import RobotConfig


@dataclass(frozen=True, slots=True, kw_only=True)
class Job:
    """The settings of a command."""

    robot: RobotConfig
    config: IngestConfig
    dry_run: bool = False
    allow_missing: bool = False
    strict: bool = False
    named: frozenset[str] = frozenset()
    """Streams whose topics the user named, so that no recording may lack them; a preset's candidates may be absent."""

    @property
    def settings_hash(self) -> str:
        """Hash of what decides an episode's content."""
        return settings_hash(self.robot, self.config)
