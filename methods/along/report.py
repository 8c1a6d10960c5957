"""What walking along recordings gives to report: counts, times, notes."""

from dataclasses import dataclass, field

from navtool.base.note import Note
from navtool.base.plain import plain_fields


@dataclass(frozen=True, slots=True, kw_only=True)
class Report:
    """What every method's report has; a method's own dataclass adds its figures."""

    out: str
    """The folder."""
    seconds: float = 0.0
    """That it took; where it was done before, 0."""
    done_before: bool = False
    """Whether it was there already, of the same input and settings."""

    def to_json(self) -> dict[str, object]:
        """As plain values; those of the moment last."""
        content: dict[str, object] = plain_fields(self)
        moment = {name: content.pop(name) for name in ("seconds", "done_before")}
        return {**content, **moment}


@dataclass(frozen=True, slots=True, kw_only=True)
class TableReport(Report):
    """The report of a method whose results are lines of a table."""

    source: str
    ticks: int
    """In the recording."""
    results: int
    """Made of them."""
    duration_s: float
    """From the first tick to the last."""
    figures: dict[str, float] = field(default_factory=dict)
    """What the method came to, by name and unit."""
    skipped: dict[str, int] = field(default_factory=dict)
    """Ticks without a result, by reason."""
    files: dict[str, int] = field(default_factory=dict)
    """Results in each output."""
    notes: list[Note] = field(default_factory=list)
    """What a user should look at."""
