"""How well a map of classes agrees with the truth, over the cells that a cloud looked at (docs/papers.md, V-B)."""

from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np
from jaxtyping import Bool, Int64, UInt8

from navtool.pipeline.arrays import Array
from navtool.pipeline.intensity_map.config import GridConfig
from navtool.pipeline.intensity_map.layer_points import LayerPoints
from navtool.pipeline.intensity_map.obstacles import CellClass
from navtool.pipeline.intensity_map.peers.occupancy_grid import passed_cells

QUESTIONS: dict[str, tuple[CellClass, ...]] = {
    "free": (CellClass.free,),
    "pliable": (CellClass.pliable,),
    "solid": (CellClass.solid,),
    "transparent": (CellClass.transparent,),
    "avoid": (CellClass.solid, CellClass.transparent),
}
"""What is asked of each cell: is it one of these? ``avoid`` is the figure that is set against the paper's F-score."""
DIRECTIONS = 1800
"""Width within which beams are one: the columns of a VLP-16 that turns ten times a second."""


class Score(NamedTuple):
    """Scores of one question; None where nothing was claimed, or nothing was there."""

    precision: float | None
    recall: float | None
    f: float | None
    """The harmonic mean of both; 0 where either is 0, None where either is None."""


@dataclass(frozen=True, slots=True)
class Counts:
    """Cells of one or several clouds, counted; counts of several add up.

    Surfaces lie anywhere in a cell and ranges are noisy, so that a return often falls into the cell beside the one that
    an outline touches. With a tolerance of one cell, a claim is right where its cell or one of the eight neighbours
    truly is what is claimed, and a true cell is found where it or one of its neighbours is claimed. Precision is over
    claims, recall over true cells.
    """

    confusion: Int64[Array, "4 4"]
    """Without tolerance: [true class, class in the map]."""
    right: Int64[Array, " q"]
    """Claims that are true within the tolerance, for each of `QUESTIONS`."""
    wrong: Int64[Array, " q"]
    """Those that are not."""
    found: Int64[Array, " q"]
    """True cells that are claimed within the tolerance."""
    missed: Int64[Array, " q"]
    """Those that are not."""

    def __add__(self, other: "Counts") -> "Counts":
        return Counts(
            self.confusion + other.confusion,
            self.right + other.right,
            self.wrong + other.wrong,
            self.found + other.found,
            self.missed + other.missed,
        )

    def score(self, question: str) -> Score:
        """Precision, recall and F of one of `QUESTIONS`, with the tolerance."""
        row = list(QUESTIONS).index(question)
        return _score(*(int(part[row]) for part in (self.right, self.wrong, self.found, self.missed)))

    def exact_score(self, question: str) -> Score:
        """The same cell by cell, without tolerance."""
        asked = list(QUESTIONS[question])
        both = int(self.confusion[np.ix_(asked, asked)].sum())
        claimed, true = int(self.confusion[:, asked].sum()), int(self.confusion[asked].sum())
        return _score(both, claimed - both, both, true - both)


def no_counts() -> Counts:
    """The counts of no cloud."""
    zero = np.zeros(len(QUESTIONS), np.int64)
    return Counts(np.zeros((len(CellClass), len(CellClass)), np.int64), zero, zero, zero, zero)


def observed_cells(points: LayerPoints, grid: GridConfig) -> Bool[Array, "n n"]:
    """The cells that a cloud has looked at: a beam ends in them, or they lie before the nearest end in their direction.

    Only beams that end in a layer count: others may have passed above or below anything. A pane that beams pass through
    is looked at, whether anything returns from it or not: what is not found counts as missed. What lies behind the
    nearest return is looked at only where a beam ends: a beam that goes on over a bush has not looked into it.

    Args:
        points: Of the cloud, sorted into layers.
        grid: Around the sensor.
    """
    turn = np.arctan2(points.y, points.x) / (2 * np.pi) + 0.5
    direction = np.minimum((turn * DIRECTIONS).astype(np.int64), DIRECTIONS - 1)
    order = np.lexsort((np.hypot(points.x, points.y), direction))
    nearest = order[np.flatnonzero(np.diff(direction[order], prepend=-1))]
    seen = passed_over(points.cell[nearest], grid)
    seen.reshape(-1)[points.cell % (grid.cells * grid.cells)] = True
    return seen


def passed_over(ends: Int64[Array, " k"], grid: GridConfig) -> Bool[Array, "n n"]:
    """The cells on the straight ways from the sensor to some cells, and these; their numbers may have layers, too."""
    cell = np.unique(ends % (grid.cells * grid.cells))
    middle = np.stack([cell // grid.cells, cell % grid.cells], axis=1) + 0.5
    seen = np.zeros(grid.cells * grid.cells, bool)
    seen[passed_cells(np.full(2, grid.cells / 2), middle, grid.cells)] = True
    return seen.reshape(grid.cells, grid.cells)


def compare(
    classes: UInt8[Array, "n n"], truth: UInt8[Array, "n n"], observed: Bool[Array, "n n"], tolerance_cells: int = 1
) -> Counts:
    """Count the cells of one cloud; claims and true cells that are not observed count for nothing.

    Args:
        classes: The map's `CellClass` for each cell.
        truth: What is there.
        observed: Of `observed_cells`, the same for every map that is compared.
        tolerance_cells: How far a claim may be off, along either axis.
    """
    number, reach = len(CellClass), 2 * tolerance_cells + 1
    around = np.ones((reach, reach), np.uint8)
    pairs = truth[observed].astype(np.int64) * number + classes[observed]
    counted = np.zeros((4, len(QUESTIONS)), np.int64)
    for row, asked in enumerate(QUESTIONS.values()):
        claims, true = np.isin(classes, asked), np.isin(truth, asked)
        near_true, near_claim = (cv2.dilate(part.view(np.uint8), around).view(bool) for part in (true, claims))
        claims, true = claims & observed, true & observed
        right, found = int((claims & near_true).sum()), int((true & near_claim).sum())
        counted[:, row] = right, int(claims.sum()) - right, found, int(true.sum()) - found
    return Counts(np.bincount(pairs, minlength=number * number).reshape(number, number), *counted)


def _score(right: int, wrong: int, found: int, missed: int) -> Score:
    precision = right / (right + wrong) if right + wrong else None
    recall = found / (found + missed) if found + missed else None
    if precision is None or recall is None:
        return Score(precision, recall, None)
    return Score(precision, recall, 2 * precision * recall / (precision + recall) if precision + recall else 0.0)
