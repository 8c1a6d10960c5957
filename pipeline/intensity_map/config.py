"""The grid, the layers and the thresholds of an intensity map."""

import math
from dataclasses import dataclass, field
from enum import StrEnum

from navtool.base.setting_checks import fault, outside
from navtool.base.setting_error import refuse


class Reduction(StrEnum):
    """What a cell of a layer holds of its points' intensities."""

    sum = "sum"
    """Their sum over the cell's area, per square metre: eq. 1 as printed. It falls with the square of the range."""
    mean = "mean"
    max = "max"


class FlatLayers(StrEnum):
    """How the layers z = 0 and z = -epsilon are cut (docs/papers.md, eq. 2)."""

    angular = "angular"
    """By elevation: the beams nearest the horizon, and the next ones below."""
    metric = "metric"
    """By height: thin slabs, which a VLP-16 has no points in beyond a metre or two."""


@dataclass(kw_only=True, slots=True)
class GridConfig:
    """A square grid around the sensor: cell (r, c) covers x from (r - n/2) g on and y from (c - n/2) g on, g wide."""

    cells: int = 200
    """n, cells along x and along y, even, 16 to 2000; the paper's 200."""
    cell_m: float = 0.1
    """g, side of a cell in metres, 0.01 to 2."""

    def __post_init__(self) -> None:
        even = "give an even number; the paper uses 200"
        refuse(
            outside(self, 16, 2000, "cells", cure=even),
            fault("cells", f"{self.cells} is odd", even, when=bool(self.cells % 2)),
            outside(self, 0.01, 2, "cell_m", unit="m"),
        )

    @property
    def half_m(self) -> float:
        """How far the grid reaches from the sensor along each axis."""
        return 0.5 * self.cells * self.cell_m


@dataclass(kw_only=True, slots=True)
class LayerConfig:
    """Which points belong to which layer, and what a cell makes of them. Heights are relative to the sensor."""

    height_m: float = 0.6
    """h: the upper layer is (0, h], the lower one [-h, 0), in metres, above 0: down to the ground's margin."""
    flat: FlatLayers = FlatLayers.angular
    """How the layers z = 0 and z = -epsilon are cut."""
    flat_rad: float = math.radians(2.0)
    """Half the opening of the angular layer z = 0, whose upper edge is at +flat_rad; z = -epsilon is the same opening
    below it. In (0, 0.2]. A VLP-16 has beams at +-1 and +-3 degrees."""
    flat_m: float = 0.02
    """Half the thickness of the metric layer z = 0; z = -epsilon is the slab of the same thickness below it."""
    sensor_height_m: float = 0.75
    """Height of the sensor above the ground that the robot stands on, in metres, above 0."""
    ground_margin_m: float = 0.2
    """Points that rise less above the lowest ones around them are ground and in no layer; 0 keeps all, as printed."""
    full_scale: float = 255.0
    """R, the largest intensity of the sensor, above 0: intensities are divided by it."""
    reduction: Reduction = Reduction.mean
    """What a cell holds: sum, mean or max."""

    def __post_init__(self) -> None:
        refuse(
            outside(self, 0, 0.2, "flat_rad", unit="rad", above=True),
            outside(self, 0, 1, "flat_m", unit="m", above=True),
            outside(self, 0, math.inf, "height_m", "sensor_height_m", "full_scale", above=True, below=True),
            outside(self, 0, 2, "ground_margin_m", unit="m", cure="0 keeps the ground"),
        )


@dataclass(kw_only=True, slots=True)
class ObstacleConfig:
    """When a cell is solid."""

    threshold: float = 0.62
    """Gamma of eq. 3: in units of R for mean and max, of R per square metre for sum. Above 0."""
    pooling_cells: int = 2
    """Intensities and points of cells up to so far away count as the cell's own, 0 to 10; 0 is eq. 3 as printed."""

    def __post_init__(self) -> None:
        refuse(
            outside(self, 0, math.inf, "threshold", above=True, cure="measure one on labelled clouds"),
            outside(self, 0, 10, "pooling_cells"),
        )


@dataclass(kw_only=True, slots=True)
class GlassConfig:
    """When a weak patch of returns is glass, how far it reaches and how long it stays (docs/papers.md, eq. 6)."""

    intensity: float = 0.2
    """Returns of glass are weaker than this, in units of R, in (0, 1]."""
    points: int = 6
    """A patch has at least so many points in the layer z = 0; at least 3."""
    mixed: float = 0.04
    """A patch with so many stronger points that are not solid in or beside its cells, for each of its own, is a curtain
    or grass; above 0."""
    thickness_m: float = 0.04
    """A patch has a standard deviation below this across its own direction and above it along it, metres, above 0."""
    incidence_rad: float = math.radians(12.0)
    """The patch faces the sensor: its normal lies within this angle of the beams, in (0, 1.5)."""
    extend_m: float = 0.5
    """The patch is the part of a pane that the beams meet at right angles: it is extended on both sides by so much, or
    to the first solid cell. In metres, 0 to 10."""
    clouds: int = 2
    """A cell is transparent once patches in so many clouds have covered it; at least 1."""
    decay_s: float = 60.0
    """It is forgotten so long after the last one, in seconds, above 0."""
    jump_m: float = 1.0
    """A pose further than this from where the robot can have driven since the one before is a jump of the odometry: all
    is forgotten then. Above 0."""
    fastest_mps: float = 3.0
    """The robot goes no faster, in metres a second, 0 to 50."""

    def __post_init__(self) -> None:
        refuse(
            outside(self, 0, 1, "intensity", above=True),
            outside(self, 3, math.inf, "points"),
            outside(self, 1, math.inf, "clouds"),
            outside(self, 0, 1.5, "incidence_rad", unit="rad", above=True, below=True),
            outside(self, 0, 10, "extend_m", unit="m"),
            outside(self, 0, math.inf, "mixed", "thickness_m", "decay_s", "jump_m", above=True),
        )


class Inflation(StrEnum):
    """In which directions obstacles grow."""

    adaptive = "adaptive"
    """Away from the goal, and a little everywhere: eq. 8 and 9."""
    uniform = "uniform"
    """Over the whole square kernel: the paper's ablation."""


@dataclass(kw_only=True, slots=True)
class InflationConfig:
    """How far obstacles grow, in cells."""

    method: Inflation = Inflation.adaptive
    """adaptive or uniform."""
    size_cells: int = 11
    """e, side of the kernel, odd, 1 to 101: obstacles grow by (e - 1) / 2 cells."""
    padding_cells: int = 1
    """Half the thickness of the line away from the goal, 0 to (e - 1) / 2."""
    minor_cells: int = 2
    """How far obstacles grow in every direction with adaptive inflation, 0 to (e - 1) / 2: half the robot's width."""

    def __post_init__(self) -> None:
        reach = (self.size_cells - 1) // 2
        refuse(
            outside(self, 1, 101, "size_cells", cure="give an odd number"),
            fault("size_cells", f"{self.size_cells} is even", "give an odd number", when=self.size_cells % 2 == 0),
        )
        refuse(outside(self, 0, reach, "padding_cells", "minor_cells", cure="give at most half of size_cells"))


@dataclass(kw_only=True, slots=True)
class IntensityMapConfig:
    """Everything that decides an intensity map."""

    grid: GridConfig = field(default_factory=GridConfig)
    layers: LayerConfig = field(default_factory=LayerConfig)
    obstacles: ObstacleConfig = field(default_factory=ObstacleConfig)
    glass: GlassConfig = field(default_factory=GlassConfig)
    inflation: InflationConfig = field(default_factory=InflationConfig)
    robot_radius_m: float = 0.4
    """How far the robot reaches around the sensor, in metres, above 0: there is no glass where it stands."""

    def __post_init__(self) -> None:
        threshold, reduction = self.obstacles.threshold, self.layers.reduction
        refuse(
            fault(
                "obstacles.threshold",
                f"{threshold:g} is not below 1, in units of R with reduction {reduction.value}: nothing would be solid",
                when=threshold >= 1 and reduction is not Reduction.sum,
            ),
            outside(self, 0, math.inf, "robot_radius_m", unit="m", above=True),
            fault(
                "inflation.size_cells",
                f"{self.inflation.size_cells} is more than grid.cells = {self.grid.cells}",
                "take a larger grid or a smaller kernel",
                when=self.inflation.size_cells > self.grid.cells,
            ),
        )
