"""What a simulation did, for people and for programs."""

from collections import Counter
from dataclasses import dataclass, field
from typing import Any

from navtool.base.note import Note
from navtool.base.plain import plain
from navtool.sim.record.episode import Episode, NotMade


@dataclass(slots=True)
class SimulationReport:
    """What a simulation did."""

    folder: str
    episodes: list[Episode] = field(default_factory=list)
    """Those that were made."""
    skipped: list[int] = field(default_factory=list)
    """Numbers of those that were there already."""
    not_made: list[NotMade] = field(default_factory=list)
    """Those that could not be driven, with the reason."""
    notes: list[Note] = field(default_factory=list)
    seconds: float = 0.0
    """Time by the clock on the wall, for all of it."""

    @property
    def minutes(self) -> float:
        """Duration of the new drives."""
        return sum(episode.duration_s for episode in self.episodes) / 60

    @property
    def failures(self) -> dict[str, int]:
        """How often each kind of failure happened on the new drives."""
        found = Counter(failure.kind.value for episode in self.episodes for failure in episode.failures)
        return dict(sorted(found.items()))

    @property
    def failed_share(self) -> float:
        """Share of the new drives' duration during which something had gone wrong, 0-1."""
        failed = sum(episode.failed_share * episode.duration_s for episode in self.episodes)
        return failed / (60 * self.minutes) if self.episodes else 0.0

    @property
    def size_bytes(self) -> int:
        """Size of the new recordings."""
        return sum(episode.size_bytes for episode in self.episodes)

    @property
    def pictures_per_s(self) -> float:
        """Recorded pictures, and with them all else, a second on the wall."""
        return sum(episode.pictures for episode in self.episodes) / max(self.seconds, 1e-9)

    @property
    def peak_rss_mib(self) -> float:
        """Memory of the process that used most."""
        return max((episode.peak_rss_mib for episode in self.episodes), default=0.0)

    def to_json(self) -> dict[str, Any]:
        """The report as JSON knows it."""
        return {
            "folder": self.folder,
            "episodes": plain(self.episodes),
            "skipped": self.skipped,
            "not_made": plain(self.not_made),
            "notes": plain(self.notes),
            "minutes": round(self.minutes, 4),
            "failures": self.failures,
            "failed_share": round(self.failed_share, 6),
            "size_bytes": self.size_bytes,
            "seconds": round(self.seconds, 3),
            "pictures_per_s": round(self.pictures_per_s, 2),
            "peak_rss_mib": round(self.peak_rss_mib, 1),
        }
