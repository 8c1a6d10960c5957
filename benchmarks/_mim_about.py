"""How the results of the intensity map were measured, for the page that shows them."""

from navtool.sim.world.scenario import Split

ABOUT = """
Simulated drives in places of the split `{split}`, seeds {first} to {last}, {seconds:g} s each by the random driver of
`navtool simulate`; a VLP-16 in dual mode (as in the paper's V-A: what lies behind a pane is brighter, and the
strongest return alone hides it). Ten clouds a second are mapped, every fourth is scored. The robot's own motion is
taken out of each cloud by its odometry, which drifts.

Truth: outlines of what stands there, as on `/ground_truth/obstacles`, seen from where the sensor truly is. A cell
belongs to an outline that it touches. Bushes are drawn where they are widest, at the ground.

Must be avoided: solid or transparent. Judged are the cells that a cloud has looked at: a beam that ends in a layer
ends in them, or they lie before the nearest such end in their direction. Glass that is not found is thus missed. The
rows with cells behind the nearest return also count all cells that any such beam passes over, such as the far side of
a bush that it passes above.

Tolerance: one cell of 0.1 m, the same for all methods. A claim is right, and a true cell is found, where the other is
in it or in one of its eight neighbours. Rows with none and with two cells stand beside it.

Intervals: F by drawing drives again (bootstrap), shares by Wilson, counts by Poisson. The paper's F-scores are from
people who judged obstacles in real places; its Glass-SLAM is the row of intensity peaks.

Panes of 1 to 4 m stand in a room and are approached from 4 to 5 m away at 0.5 m/s, the robot's whole width against
the pane. The distance is the sensor's from the pane along its way when the first cell in its way, within 0.4 m of
the pane, is transparent. A pane answers only where a beam meets it within 16 degrees of its normal: at an angle
that may be beside the pane.

False panes: patches of transparent cells in the odometry frame, half a metre apart from all before, in places without
glass (mim_3 and mim_4), as many seeds from the first on as make ten minutes.

Doors: a room is divided by a wall with a door and seen once, from 1.5 to 4 m and within 30 degrees of the door's
normal, the goal behind it. A door is open where cells that cost 0 lead from robot to goal side by side. The kernel
has 11 cells; adaptive inflation grows obstacles by 3 cells in every direction, half of 0.5 m rounded up.

Memory: {minutes} minutes at 10 Hz, a stretch among glass that is driven again and again while its odometry goes on.
Growth is the mean of the last third of the samples over that of the second sixth.

Where a peer scores higher indoors: nearly all that returns there is solid, so that taking every return for solid is
nearly right, while walls at grazing angles and behind panes look pliable to the intensity map. In dual mode panes
return to the peers, too, from where they are met at right angles; the peers forget them or take them for solid, and
none of them tells what yields.
"""


def about(split: Split, seeds: range, seconds: float, minutes: int) -> list[str]:
    """The paragraphs, with the figures of a run."""
    told = ABOUT.format(split=split.value, first=seeds[0], last=seeds[-1], seconds=seconds, minutes=minutes)
    return [" ".join(paragraph.split()) for paragraph in told.strip().split("\n\n")]
