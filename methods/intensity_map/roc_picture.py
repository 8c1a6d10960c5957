"""The curves of a fitted threshold as a picture."""

from jaxtyping import Float64

from navtool.methods.intensity_map.fit_threshold import Candidate, ThresholdFit
from navtool.pipeline.arrays import Array

_SIDE, _LEFT, _TOP, _WIDTH, _HEIGHT = 420, 56, 54, 860, 530
_MOST_POINTS = 400
_STYLE = (
    "text{font:12px sans-serif;fill:#24292f}.dim{fill:#6e7781}.lane{fill:#f6f8fa;stroke:#d0d7de}"
    "path{fill:none;stroke-width:1.5}.other{stroke:#b6bec6}.best{stroke:#2f81b7;stroke-width:2.5}"
    ".chance{stroke:#b6bec6;stroke-dasharray:4}.point{fill:#d1495b}"
    "@media(prefers-color-scheme:dark){text{fill:#e6edf3}.dim{fill:#9198a1}.lane{fill:#161b22;stroke:#30363d}}"
)


def roc_picture(fit: ThresholdFit, unit: str) -> str:
    """An SVG: the rates for every threshold, the chosen heights' curve above the others', and the chosen point.

    Args:
        fit: What was found.
        unit: Of the threshold.
    """
    best = fit.best
    x, y = _place(best.best.false_positive_rate, best.best.true_positive_rate)
    told = f"threshold {best.best.threshold:.3g} {unit}: {best.best.true_positive_rate:.1%} of solid cells above it, "
    told += f"{best.best.false_positive_rate:.1%} of the others"
    counted = ", ".join(f"{number} {kind}" for kind, number in fit.cells.items())
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {_WIDTH} {_HEIGHT}" role="img">',
        f"<title>Solid cells told from others</title><style>{_STYLE}</style>",
        f'<text x="{_LEFT}" y="20">{told}</text>',
        f'<text class="dim" x="{_LEFT}" y="38">{counted} cells of {fit.sweeps} sweeps</text>',
        f'<rect class="lane" x="{_LEFT}" y="{_TOP}" width="{_SIDE}" height="{_SIDE}"/>',
        f'<path class="chance" d="M{_LEFT} {_TOP + _SIDE}L{_LEFT + _SIDE} {_TOP}"/>',
        *(f'<path class="other" d="{_curve(candidate)}"/>' for candidate in fit.candidates[1:]),
        f'<path class="best" d="{_curve(best)}"/>',
        f'<circle class="point" cx="{x:.1f}" cy="{y:.1f}" r="5"/>',
    ]
    for share in (0.0, 0.25, 0.5, 0.75, 1.0):
        x, y = _place(share, share)
        parts.append(f'<text class="dim" x="{x - 12:.1f}" y="{_TOP + _SIDE + 18}">{share:g}</text>')
        parts.append(f'<text class="dim" x="{_LEFT - 34}" y="{y + 4:.1f}">{share:g}</text>')
    parts.append(
        f'<text x="{_LEFT}" y="{_TOP + _SIDE + 40}">share of pliable and free cells above the threshold</text>'
    )
    parts.append(f'<text transform="translate(14 {_TOP + _SIDE})rotate(-90)">share of solid cells above it</text>')
    left = _LEFT + _SIDE + 24
    parts.append(f'<text x="{left}" y="{_TOP + 12}">heights tried, best first</text>')
    for row, candidate in enumerate(fit.candidates[:20]):
        text = f"h {candidate.height_m:g} m, margin {candidate.ground_margin_m:g} m: "
        text += f"J {candidate.gain:.3f}, area {candidate.curve.area:.3f}, threshold {candidate.best.threshold:.3g}"
        parts.append(f'<text{"" if row == 0 else " class='dim'"} x="{left}" y="{_TOP + 34 + 19 * row}">{text}</text>')
    return "\n".join([*parts, "</svg>\n"])


def _place(false_positive_rate: float, true_positive_rate: float) -> tuple[float, float]:
    return _LEFT + _SIDE * false_positive_rate, _TOP + _SIDE * (1 - true_positive_rate)


def _curve(candidate: Candidate) -> str:
    """The path of a curve, thinned to what can be seen."""
    false, true = _thin(candidate.curve.false_positive_rate), _thin(candidate.curve.true_positive_rate)
    places = (_place(*rates) for rates in zip(false.tolist(), true.tolist(), strict=True))
    return "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in places)


def _thin(rates: Float64[Array, " t"]) -> Float64[Array, " k"]:
    if rates.size <= _MOST_POINTS:
        return rates
    step = rates.size / _MOST_POINTS
    return rates[[*(int(k * step) for k in range(_MOST_POINTS)), rates.size - 1]]
