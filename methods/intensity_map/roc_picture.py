"""The curves of a fitted threshold as a picture."""

from jaxtyping import Float64

from navtool.base.pages.svg import Axes, dot, svg_file, text
from navtool.methods.intensity_map.fit_threshold import Candidate, ThresholdFit
from navtool.pipeline.arrays import Array

_SIDE, _LEFT, _TOP, _WIDTH, _HEIGHT = 420, 56, 54, 860, 530
_MOST_POINTS = 400
_SHARES = ("0", "0.25", "0.5", "0.75", "1")


def roc_picture(fit: ThresholdFit, unit: str) -> str:
    """An SVG: the rates for every threshold, the chosen heights' curve above the others', and the chosen point.

    Args:
        fit: What was found.
        unit: Of the threshold.
    """
    axes, best = Axes(left=_LEFT, top=_TOP, width=_SIDE, height=_SIDE), fit.best
    chosen = best.best
    rates = f"threshold {chosen.threshold:.3g} {unit}: {chosen.true_positive_rate:.1%} of solid cells above it, "
    rates += f"{chosen.false_positive_rate:.1%} of the others"
    counted = ", ".join(f"{number} {kind}" for kind, number in fit.cells.items())
    foot = _TOP + _SIDE
    parts = [
        text(_LEFT, 20, rates),
        text(_LEFT, 38, f"{counted} cells of {fit.sweeps} sweeps", "dim"),
        axes.frame(),
        axes.line("faint dashed", [0, 1], [0, 1]),
        *(_curve(axes, "faint", candidate) for candidate in fit.candidates[1:]),
        _curve(axes, "path", best),
        dot("lost", axes.x(chosen.false_positive_rate), axes.y(chosen.true_positive_rate)),
        *axes.x_ticks(_SHARES, foot + 18),
        *axes.y_ticks(_SHARES),
        text(_LEFT, foot + 40, "share of pliable and free cells above the threshold"),
        text(14, foot, "share of solid cells above it", upwards=True),
        *_heights(fit),
    ]
    return svg_file(_WIDTH, _HEIGHT, "Solid cells told from others", parts)


def _heights(fit: ThresholdFit) -> list[str]:
    """The list of what was tried, beside the curves."""
    left = _LEFT + _SIDE + 24
    parts = [text(left, _TOP + 12, "heights tried, best first")]
    for row, candidate in enumerate(fit.candidates[:20]):
        line = f"h {candidate.height_m:g} m, margin {candidate.ground_margin_m:g} m: "
        line += f"J {candidate.gain:.3f}, area {candidate.curve.area:.3f}, threshold {candidate.best.threshold:.3g}"
        parts.append(text(left, _TOP + 34 + 19 * row, line, "dim" if row else ""))
    return parts


def _curve(axes: Axes, kind: str, candidate: Candidate) -> str:
    """A curve, thinned to what can be seen."""
    return axes.line(kind, _thin(candidate.curve.false_positive_rate), _thin(candidate.curve.true_positive_rate))


def _thin(rates: Float64[Array, " t"]) -> Float64[Array, " k"]:
    if rates.size <= _MOST_POINTS:
        return rates
    step = rates.size / _MOST_POINTS
    return rates[[*(int(k * step) for k in range(_MOST_POINTS)), rates.size - 1]]
