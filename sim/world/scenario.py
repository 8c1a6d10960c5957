"""What a scenario asks of a world: its ground, what stands there, the weather and the light."""

from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path

import yaml

from navtool.base.from_plain import from_plain
from navtool.base.setting_checks import fault, outside
from navtool.base.setting_error import Fault, refuse
from navtool.base.yaml_text import load_yaml
from navtool.sim.errors import SimError
from navtool.sim.world.surfaces import GROUND

_GROUND_NAMES = tuple(surface.name for surface in GROUND)


class Split(StrEnum):
    """Which of two disjoint families of places a seed is drawn from."""

    train = "train"
    test = "test"


class RegionShape(StrEnum):
    """How a region of the ground lies."""

    patches = "patches"
    """Irregular patches all over the place."""
    path = "path"
    """A winding strip from the start's side to the goal's."""
    band = "band"
    """Everything between two distances along the way from start to goal."""


class Partition(StrEnum):
    """What divides a room between start and goal."""

    none = "none"
    glass = "glass"
    """A wall of glass with a gap to walk through."""
    curtain = "curtain"
    """A wall with a doorway behind a curtain, and a glass panel beside it."""


def _no_ground(settings: "RegionConfig | ScenarioConfig", name: str) -> list[Fault]:
    ground: str = getattr(settings, name)
    known = f"known are {', '.join(_GROUND_NAMES)}"
    return fault(name, f"there is no ground {ground!r}", known, when=ground not in _GROUND_NAMES)


def _empty_band(band: "RegionConfig | Scatter") -> list[Fault]:
    what = f"{band.from_m} m is not below to_m = {band.to_m} m"
    return fault("from_m", what, "let the band begin before it ends", when=not band.from_m < band.to_m)


@dataclass(kw_only=True, slots=True)
class RegionConfig:
    """A part of the ground of another surface; later regions lie over earlier ones."""

    surface: str
    """Name of a ground surface."""
    shape: RegionShape = RegionShape.patches
    """How it lies."""
    share: float = 0.2
    """Share of the ground that ``patches`` cover, in (0, 1)."""
    size_m: float = 6.0
    """Typical size of ``patches``, width of a ``path``. In metres, in [0.5, 30]."""
    from_m: float = 0.0
    """Where a ``band`` begins along x in metres; the start is at negative x, the goal at positive x."""
    to_m: float = 100.0
    """Where a ``band`` ends along x in metres."""

    def __post_init__(self) -> None:
        refuse(
            _no_ground(self, "surface"),
            outside(self, 0, 1, "share", above=True, below=True),
            outside(self, 0.5, 30, "size_m", unit="m"),
            _empty_band(self),
        )


@dataclass(kw_only=True, slots=True)
class Scatter:
    """How many of a kind stand in the place, and where."""

    count: int = 0
    """How many, 0 to 400."""
    from_m: float = -100.0
    """Least x in metres; the start is at negative x, the goal at positive x."""
    to_m: float = 100.0
    """Largest x in metres."""
    gap_m: float = 1.2
    """Free width between its outline and its neighbours' in metres, -1 (intertwined) to 10."""
    size: list[float] = field(default_factory=lambda: [0.0, 1.0])
    """Least and largest size within the kind's range, 0 (smallest) to 1 (largest)."""

    def __post_init__(self) -> None:
        sizes = len(self.size) == 2 and 0 <= self.size[0] <= self.size[1] <= 1
        refuse(
            outside(self, 0, 400, "count"),
            outside(self, -1, 10, "gap_m", unit="m"),
            _empty_band(self),
            fault("size", f"{self.size} is not the least and the largest size, both within 0-1", when=not sizes),
        )


@dataclass(kw_only=True, slots=True)
class RoomConfig:
    """Four walls and a ceiling around start and goal."""

    length_m: float = 14.0
    """Along the way from start to goal, 6 to 40 m."""
    width_m: float = 8.0
    """Across it, 3 to 40 m."""
    height_m: float = 2.8
    """Height of the ceiling, 2 to 6 m."""
    partition: Partition = Partition.none
    """What divides it in the middle."""
    passage_m: float = 1.1
    """Width of the way through the partition, 0.8 to 3 m."""

    def __post_init__(self) -> None:
        refuse(
            outside(self, 6, 40, "length_m", unit="m"),
            outside(self, 3, 40, "width_m", unit="m"),
            outside(self, 2, 6, "height_m", unit="m"),
            outside(self, 0.8, 3, "passage_m", unit="m"),
        )


@dataclass(kw_only=True, slots=True)
class LightConfig:
    """How bright the place is."""

    illuminance_lux: float = 50_000.0
    """On level ground in the open: noon 100,000, overcast 10,000, indoors 300, dusk 10, full moon 0.2. Above 0."""
    sun_share: float = 0.8
    """Share of it that comes straight from the sun, 0 (overcast, indoors) to 0.9."""
    sun_elevation_rad: list[float] = field(default_factory=lambda: [0.5, 1.1])
    """Least and largest elevation of the sun, each in (0, pi/2)."""

    def __post_init__(self) -> None:
        angles = self.sun_elevation_rad
        rises = len(angles) == 2 and 0.05 <= angles[0] <= angles[1] <= 1.57
        refuse(
            outside(self, 0, 200_000, "illuminance_lux", unit="lux", above=True),
            outside(self, 0, 0.9, "sun_share"),
            fault(
                "sun_elevation_rad",
                f"{angles} is not the least and the largest angle, both within 0.05-1.57 rad",
                when=not rises,
            ),
        )


@dataclass(kw_only=True, slots=True)
class WeatherConfig:
    """What is in the air."""

    rain_mmph: float = 0.0
    """Rain in millimetres an hour: drizzle 1, heavy 25; 0 to 100."""
    dust_per_m: float = 0.0
    """Extinction of light by dust, per metre: 0.02 a haze, 0.2 a dense cloud; 0 to 1."""

    def __post_init__(self) -> None:
        refuse(outside(self, 0, 100, "rain_mmph", unit="mm/h"), outside(self, 0, 1, "dust_per_m", unit="per m"))


@dataclass(kw_only=True, slots=True)
class ScenarioConfig:
    """A kind of place; a seed makes one place of it. Start and goal lie on the x axis, the world's origin between them.

    Test places and training places never are the same: ``split`` is part of what the seed is drawn from.
    """

    name: str = "place"
    """Part of what a place is drawn from: two scenarios with different names have different places."""
    split: Split = Split.test
    """Which family of places the seeds number."""
    side_m: float = 48.0
    """Side of the square that is modelled in full, 20 to 120 m."""
    cell_m: float = 0.1
    """Side of a cell of the ground, 0.05 to 0.5 m."""
    course_m: float = 22.0
    """Distance from start to goal, 4 m to the side less 6 m."""
    hills_m: float = 0.2
    """Standard deviation of the ground's height at wavelengths of 15 m, 0 to 3 m."""
    ground: str = "grass"
    """Name of the ground surface where no region lies."""
    regions: list[RegionConfig] = field(default_factory=list)
    """Parts of the ground of other surfaces."""
    trees: Scatter = field(default_factory=Scatter)
    """Trunks with crowns above head height."""
    hanging_trees: Scatter = field(default_factory=Scatter)
    """Trees whose leaves hang down to a robot's sensors."""
    bushes: Scatter = field(default_factory=Scatter)
    """Bushes that do not yield."""
    grass_patches: Scatter = field(default_factory=Scatter)
    """Patches of tall grass, which yields."""
    rocks: Scatter = field(default_factory=Scatter)
    """Boulders."""
    walls: Scatter = field(default_factory=Scatter)
    """Free-standing walls of brick or concrete."""
    pillars: Scatter = field(default_factory=Scatter)
    """Pillars of concrete and poles of steel."""
    glass_panels: Scatter = field(default_factory=Scatter)
    """Free-standing panes of glass."""
    curtains: Scatter = field(default_factory=Scatter)
    """Bead curtains between two poles."""
    room: RoomConfig | None = None
    """Walls and ceiling around it all; None is the outdoors."""
    light: LightConfig = field(default_factory=LightConfig)
    """Brightness and sun."""
    weather: WeatherConfig = field(default_factory=WeatherConfig)
    """Rain and dust."""

    def __post_init__(self) -> None:
        refuse(
            _no_ground(self, "ground"),
            outside(self, 20, 120, "side_m", unit="m"),
            outside(self, 0.05, 0.5, "cell_m", unit="m"),
            outside(self, 4, self.side_m - 6, "course_m", unit="m", cure="leave 3 m of side_m at both ends"),
            outside(self, 0, 3, "hills_m", unit="m"),
        )
        if self.room is not None:
            room = f"does not fit into a room of {self.room.length_m} m"
            refuse(
                fault(
                    "course_m",
                    f"{self.course_m} m {room}",
                    "leave 1 m at both ends",
                    when=self.course_m > self.room.length_m - 2,
                )
            )


def load_scenario(path: Path) -> ScenarioConfig:
    """The scenario of a YAML file such as those in configs/scenario; the list of defaults, for Hydra, is passed over.

    Raises:
        SimError: The file cannot be read, or is not YAML.
        SettingError: It has unknown keys or wrong values; all are named.
    """
    try:
        content = load_yaml(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise SimError(f"cannot be read ({error.strerror})", where=path, cure="check the scenario's path") from error
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise SimError("is not YAML", where=path, cure=f"correct it: {' '.join(str(error).split())}") from error
    if isinstance(content, dict):
        content.pop("defaults", None)
    return from_plain(ScenarioConfig, content, where=path)
