"""What an ingest did, for people and for programs."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from navtool.base.errors import DatasetsError
from navtool.base.note import Note
from navtool.base.plain import plain


@dataclass(frozen=True, slots=True)
class Quarantined:
    """A recording that gave no episode, and why."""

    path: str
    reason: str

    @classmethod
    def of(cls, path: Path, error: DatasetsError) -> "Quarantined":
        """The recording with the reason that its error names, and the cure."""
        reason = error.what if error.where in (None, str(path)) else f"{error.where}: {error.what}"
        return cls(str(path), reason if error.cure is None else f"{reason} ({error.cure})")


@dataclass(slots=True)
class EpisodeSummary:
    """One episode as ingest reports it."""

    episode: int
    """Its number in the data set, in a dry run the one that it would have."""
    source: str
    rows: int
    topics: dict[str, str]
    not_used: list[dict[str, Any]]
    dropped: dict[str, int]
    sync: dict[str, Any]
    notes: list[Note]
    rebuilt: bool = False
    """Whether it replaces an older episode of the same recording."""


@dataclass(slots=True)
class IngestReport:
    """What an ingest did."""

    dataset: str
    dry_run: bool
    episodes_before: int = 0
    """Episodes of the data set that this one began with."""
    episodes: list[EpisodeSummary] = field(default_factory=list)
    skipped: list[str] = field(default_factory=list)
    """Recordings that the data set had already."""
    placed: dict[str, str] = field(default_factory=dict)
    """Skipped recordings whose place is another one now."""
    quarantined: list[Quarantined] = field(default_factory=list)
    seconds: float = 0.0
    bytes_in: int = 0
    peak_rss_mib: float = 0.0
    """Peak memory of the process that used most."""

    @property
    def rows(self) -> int:
        """Rows of the new episodes."""
        return sum(episode.rows for episode in self.episodes)

    @property
    def dropped(self) -> dict[str, int]:
        """Messages that reached no row, by reason, over all episodes."""
        total: dict[str, int] = {}
        for episode in self.episodes:
            for reason, count in episode.dropped.items():
                total[reason] = total.get(reason, 0) + count
        return total

    def to_json(self) -> dict[str, object]:
        """The report as ``navtool ingest --json`` prints it."""
        return {
            "dataset": self.dataset,
            "dry_run": self.dry_run,
            "episodes_before": self.episodes_before,
            "episodes": len(self.episodes),
            "rows": self.rows,
            "dropped": self.dropped,
            "quarantined": [plain(entry) for entry in self.quarantined],
            "skipped": self.skipped,
            "placed": self.placed,
            "seconds": round(self.seconds, 3),
            "bytes_in": self.bytes_in,
            "peak_rss_mib": round(self.peak_rss_mib, 1),
            "recordings": [plain(episode) for episode in self.episodes],
        }
