"""What is wrong with recorded velocities as a whole, by the poses: parts never filled, units, signs, a turn."""

from jaxtyping import Float64

from navtool.datasets.streams.pose_travel import PoseTravel
from navtool.datasets.streams.twist_comparison import TwistComparison, Witnesses
from navtool.datasets.streams.twist_fill import fill_empty
from navtool.datasets.streams.twist_linear import mend_linear
from navtool.datasets.streams.twist_turning import mend_turning
from navtool.datasets.streams.twist_windows import windows
from navtool.pipeline.arrays import Array


def mend_columns(speeds: Float64[Array, "n 3"], travel: PoseTravel, witnesses: Witnesses) -> TwistComparison:
    """Fill what was never filled, and bring the rest into metres, radians and the body's own axes."""
    columns = TwistComparison(speeds.copy(), travel, witnesses, windows(travel))
    if columns.found.start.size:
        fill_empty(columns)
        if not columns.taken[0]:
            mend_linear(columns)
        if not columns.taken[2]:
            mend_turning(columns)
    return columns
