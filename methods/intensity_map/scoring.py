"""How well the maps of a run agree with what stands there (MIM, NOTES M7)."""

from dataclasses import dataclass

from jaxtyping import Float64

from navtool.methods.along.place_truth import PlaceTruth
from navtool.methods.intensity_map.mapped import MappedSweep
from navtool.pipeline.arrays import Array
from navtool.pipeline.intensity_map.layer_points import sort_points
from navtool.pipeline.intensity_map.score import QUESTIONS, compare, no_counts, observed_cells


@dataclass(frozen=True, slots=True)
class ClassScore:
    """Of one question asked of each cell that was looked at; None where nothing was claimed, or nothing was there."""

    precision: float | None
    recall: float | None
    f: float | None
    """The harmonic mean of both; of ``avoid``, solid or transparent, it is the figure of the paper's tables."""


class Scoring:
    """Compares maps with the truth, one after the other."""

    def __init__(self, known: PlaceTruth, base_lidar: Float64[Array, "4 4"]) -> None:
        self._known, self._base_lidar = known, base_lidar
        self._counts = no_counts()
        self._met = False
        self.unplaced = 0
        """Maps at moments when the robot's place among the outlines is not known."""

    def add(self, mapped: MappedSweep) -> None:
        """Count the cells of a map."""
        sweep, grid = mapped.sweep, mapped.config.grid
        truth = self._known.classes_around(sweep, self._base_lidar, grid)
        if truth is None:
            self.unplaced += 1
            return
        self._met |= bool(truth.any())
        points = sort_points(sweep.xyz, sweep.intensity, grid, mapped.config.layers)
        self._counts += compare(mapped.classes, truth, observed_cells(points, grid))

    def notes(self) -> list[str]:
        """What a user should look at."""
        if self._met:
            return []
        return ["truth: none of the outlines lies within a map: look at their frame, and whether they are in metres"]

    def scores(self) -> dict[str, ClassScore]:
        """By the names of `QUESTIONS`, with their tolerance of one cell."""
        return {question: ClassScore(*self._counts.score(question)) for question in QUESTIONS}
