"""How well classes of cells agree with what stands there."""

from dataclasses import dataclass

from jaxtyping import Bool, Float64, UInt8

from navtool.base.note import Note
from navtool.methods.along.place_truth import PlaceTruth
from navtool.methods.along.sweeps import Sweep
from navtool.pipeline.arrays import Array
from navtool.pipeline.intensity_map.config import GridConfig
from navtool.pipeline.intensity_map.score import QUESTIONS, compare, no_counts


@dataclass(frozen=True, slots=True)
class ClassScore:
    """The answers to one question, asked of each cell that was looked at; None where nothing was claimed or there."""

    precision: float | None
    recall: float | None
    f: float | None
    """The harmonic mean of both; of ``avoid``, solid or transparent, it is the figure of the paper's tables."""


class CellScores:
    """Compares the cells around the sensor with the truth, sweep by sweep."""

    def __init__(self, known: PlaceTruth, base_lidar: Float64[Array, "4 4"]) -> None:
        self._known, self._base_lidar = known, base_lidar
        self._counts = no_counts()
        self._met = False
        self.unplaced = 0
        """Sweeps at moments when the robot's place among the outlines is not known."""

    def add(self, sweep: Sweep, classes: UInt8[Array, "n n"], observed: Bool[Array, "n n"], grid: GridConfig) -> None:
        """Count the cells of a sweep.

        Args:
            sweep: What the classes were made of.
            classes: A `CellClass` for each cell.
            observed: The cells that the sweep shows.
            grid: Of the cells.
        """
        truth = self._known.classes_around(sweep, self._base_lidar, grid)
        if truth is None:
            self.unplaced += 1
            return
        self._met |= bool(truth.any())
        self._counts += compare(classes, truth, observed)

    def notes(self) -> list[Note]:
        """What a user should look at."""
        if self._met:
            return []
        what = "none of the outlines lies within a map: look at their frame, and whether they are in metres"
        return [Note("truth.out-of-sight", f"truth: {what}")]

    def scores(self) -> dict[str, ClassScore]:
        """By the names of `QUESTIONS`, with their tolerance of one cell."""
        return {question: ClassScore(*self._counts.score(question)) for question in QUESTIONS}
