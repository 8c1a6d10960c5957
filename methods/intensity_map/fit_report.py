"""What fitting a threshold reports: what was chosen, what else was tried, on what."""

from dataclasses import dataclass, field

from navtool.base.note import Note
from navtool.methods.along.report import Report
from navtool.methods.intensity_map.fit_threshold import Candidate, ThresholdFit, ThresholdFitConfig

_WEAK_AREA = 0.75
"""A curve with a smaller area is hardly worth a threshold."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Tried:
    """One pair of heights with its best threshold."""

    height_m: float
    ground_margin_m: float
    threshold: float
    true_positive_rate: float
    """Share of the solid cells above it."""
    false_positive_rate: float
    """Share of the pliable and free cells above it."""
    gain: float
    """The difference of both: Youden's J."""
    area: float
    """Under the curve of all thresholds; 0.5 is chance."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FitReport(Report):
    """One fit, in figures."""

    inputs: list[str]
    settings: dict[str, float]
    """What was chosen, by the names of `IntensityMapConfig`."""
    tried: list[Tried]
    """The chosen one first, then by what they gain."""
    sweeps: int
    cells: dict[str, int]
    """Cells of each kind, summed over the sweeps."""
    sensor_heights_m: list[float]
    """Above the ground, of each input."""
    skipped: dict[str, int] = field(default_factory=dict)
    """Clouds that were not looked at, by reason; those in between are not counted."""
    notes: list[Note] = field(default_factory=list)


def tried(fit: ThresholdFit) -> list[Tried]:
    """All candidates of a fit in figures."""
    return [_tried(candidate) for candidate in fit.candidates]


def doubts(fit: ThresholdFit, config: ThresholdFitConfig) -> list[Note]:
    """What speaks against a fit."""
    best = fit.best
    found = []
    if best.curve.area < _WEAK_AREA:
        area = f"the area under the curve is {best.curve.area:.2f}, where 0.5 is chance"
        what = f"{area}: intensities hardly tell solid from pliable, or the outlines lie elsewhere than the things"
        found.append(Note("fit.weak", what))
    for name, chosen, values in (
        ("heights_m", best.height_m, config.heights_m),
        ("ground_margins_m", best.ground_margin_m, config.ground_margins_m),
    ):
        edge = {min(values): "least", max(values): "largest"}.get(chosen)
        if edge is not None and len(values) > 1:
            what = f"of tried.{name}, the {edge} gains most ({chosen:g} m): try more"
            found.append(Note("fit.at-an-end", what))
    return found


def _tried(candidate: Candidate) -> Tried:
    return Tried(
        height_m=candidate.height_m,
        ground_margin_m=candidate.ground_margin_m,
        threshold=candidate.best.threshold,
        true_positive_rate=candidate.best.true_positive_rate,
        false_positive_rate=candidate.best.false_positive_rate,
        gain=candidate.gain,
        area=candidate.curve.area,
    )
