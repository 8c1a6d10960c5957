"""The threshold between solid and pliable, and the heights that go with it, from sweeps whose truth is known."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import product
from typing import NamedTuple

import cv2
import numpy as np
from jaxtyping import Float32, UInt8

from navtool.base.errors import DatasetsError
from navtool.base.setting_checks import fault, outside
from navtool.base.setting_error import Fault, SettingError, refuse
from navtool.methods.along.sweeps import Sweep
from navtool.pipeline.arrays import Array
from navtool.pipeline.intensity_map.config import IntensityMapConfig, LayerConfig
from navtool.pipeline.intensity_map.layer_points import sort_points
from navtool.pipeline.intensity_map.layers import intensity_layers
from navtool.pipeline.intensity_map.obstacles import CellClass
from navtool.pipeline.intensity_map.solidity import solidity
from navtool.pipeline.roc import Roc, RocPoint, roc

_NEIGHBOURS = np.ones((3, 3), np.uint8)


@dataclass(kw_only=True, slots=True)
class ThresholdFitConfig:
    """What is tried, on how much of a recording."""

    every_s: float = 0.5
    """Time between two sweeps that are looked at, 0 to 60 seconds: neighbours show the same."""
    heights_m: list[float] = field(default_factory=lambda: [0.4, 0.6, 0.8, 1.0])
    """Values of ``height_m`` that are tried, in metres."""
    ground_margins_m: list[float] = field(default_factory=lambda: [0.1, 0.15, 0.2, 0.3])
    """Values of ``ground_margin_m`` that are tried, in metres."""

    def __post_init__(self) -> None:
        refuse(
            outside(self, 0, 60, "every_s", unit="s", cure="0 takes every sweep"),
            fault("heights_m", "is empty", "give one value at least", when=not self.heights_m),
            fault("ground_margins_m", "is empty", "give one value at least", when=not self.ground_margins_m),
            *(_refused("heights_m", partial(LayerConfig, height_m=value)) for value in self.heights_m),
            *(
                _refused("ground_margins_m", partial(LayerConfig, ground_margin_m=value))
                for value in self.ground_margins_m
            ),
        )


def _refused(key: str, tried: Callable[[], LayerConfig]) -> list[Fault]:
    """What the layers say of a height that is to be tried."""
    try:
        tried()
    except SettingError as error:
        return [entry._replace(key=key) for entry in error.faults]
    return []


class Candidate(NamedTuple):
    """One pair of heights, and what a threshold can do with it."""

    height_m: float
    ground_margin_m: float
    curve: Roc
    """Solid cells are the positives; cells of what yields, and free ones with returns, the negatives."""
    best: RocPoint

    @property
    def gain(self) -> float:
        """Youden's J of the best threshold, 0 to 1."""
        return self.best.true_positive_rate - self.best.false_positive_rate


@dataclass(frozen=True, slots=True)
class ThresholdFit:
    """The best settings, and what else was tried."""

    candidates: tuple[Candidate, ...]
    """The best first."""
    sweeps: int
    """How many were looked at."""
    cells: dict[str, int]
    """How many cells of each kind were, summed over the sweeps."""

    @property
    def best(self) -> Candidate:
        """The one that was chosen."""
        return self.candidates[0]

    def settings(self) -> dict[str, float]:
        """What to set, by the names of `IntensityMapConfig`, rounded to what can be told from each other."""
        return {
            "obstacles.threshold": float(f"{self.best.best.threshold:.3g}"),
            "layers.height_m": self.best.height_m,
            "layers.ground_margin_m": self.best.ground_margin_m,
        }


class ThresholdFitter:
    """Looks at sweeps one by one. Memory: 4 bytes a cell with returns, sweep and candidate.

    A cell counts once a sweep, where it has returns with any of the candidates: with another one that leaves it empty
    it is not solid, so that heights which miss low things lose by it. Cells of glass are left out, for they are found
    otherwise, and so are free cells that touch something solid: surfaces and ranges are not exact to a cell.
    """

    def __init__(self, config: IntensityMapConfig, tried: ThresholdFitConfig) -> None:
        """Prepare it.

        Args:
            config: Grid, sensor's scale, reduction and pooling; its threshold and heights do not matter.
            tried: Heights to try.
        """
        self._config = config
        self._layers = [
            replace(config.layers, height_m=height_m, ground_margin_m=margin_m)
            for height_m, margin_m in product(tried.heights_m, tried.ground_margins_m)
        ]
        self._figures: list[list[Float32[Array, " k"]]] = [[] for _ in self._layers]
        self._kinds: list[UInt8[Array, " k"]] = []

    def add(self, sweep: Sweep, truth: UInt8[Array, "n n"], sensor_height_m: float) -> None:
        """Look at a sweep.

        Args:
            sweep: Of a sensor that is level.
            truth: The `CellClass` of each cell around it.
            sensor_height_m: Above the ground.
        """
        maps = [self._solidity(sweep, replace(one, sensor_height_m=sensor_height_m)) for one in self._layers]
        hard = (truth == CellClass.solid) | (truth == CellClass.transparent)
        beside = cv2.dilate(hard.view(np.uint8), _NEIGHBOURS).view(bool)
        asked = (truth == CellClass.solid) | (truth == CellClass.pliable) | ((truth == CellClass.free) & ~beside)
        asked &= np.any([one > 0 for one in maps], axis=0)
        self._kinds.append(truth[asked])
        for figures, one in zip(self._figures, maps, strict=True):
            figures.append(one[asked])

    def fit(self) -> ThresholdFit:
        """The best of all.

        Raises:
            DatasetsError: There was nothing solid in sight, or nothing that yields.
        """
        kinds = np.concatenate([np.zeros(0, np.uint8), *self._kinds])
        cells = {kind.name: int((kinds == kind).sum()) for kind in (CellClass.solid, CellClass.pliable, CellClass.free)}
        if missing := [name for name in ("solid", "pliable") if not cells[name]]:
            what = f"no return came from anything {' or '.join(missing)}, by the outlines, in {len(self._kinds)} sweeps"
            raise DatasetsError(what, cure="take a recording that passes both, and check the outlines' frame")
        solid = kinds == CellClass.solid
        candidates = []
        for layers, figures in zip(self._layers, self._figures, strict=True):
            figure = np.concatenate(figures)
            curve = roc(figure[solid], figure[~solid])
            candidates.append(Candidate(layers.height_m, layers.ground_margin_m, curve, curve.best()))
        candidates.sort(key=lambda candidate: -candidate.gain)
        return ThresholdFit(tuple(candidates), len(self._kinds), cells)

    def _solidity(self, sweep: Sweep, layers: LayerConfig) -> Float32[Array, "n n"]:
        grid = self._config.grid
        points = sort_points(sweep.xyz, sweep.intensity, grid, layers)
        return solidity(intensity_layers(points, grid, layers), grid, layers, self._config.obstacles)
