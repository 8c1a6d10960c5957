"""The table of surfaces, and the same numbers as arrays by surface number.

Where the numbers come from:

- ``reflectivity`` at 905 nm. The ASTER spectral library (Johns Hopkins samples, 0.90-0.91 um) has 0.51 for green sod,
  0.60 for dry sod, 0.55 for a pile of leaves of broad-leaved trees, 0.28 for weathered asphalt full of limestone.
  From there: grass 0.50. A single leaf scatters less than a pile, in which light is scattered again and again: 40-50
  % in the near infrared, by textbooks of remote sensing; so 0.48 for leaves of trees and bushes, and 0.40, their
  lower end, for blades of tall grass. All others are chosen: asphalt 0.17, darker than that weathered one; concrete
  and gravel 0.30, sand 0.50, plaster 0.70; bark, rock and brick 0.36-0.38; mulch 0.25; wet mud 0.10, far below dry
  soil, because water absorbs and darkens; beads and steel.
- Glass mirrors 4 % at each of its two faces (Fresnel, refractive index 1.5): it lets 0.85 of a beam through after
  absorption. ``specular`` is chosen: of the mirrored 8 %, a receiver's aperture and the waviness of a pane leave
  little, and MIM finds glass weak (< 0.5 R) even at normal incidence.
- ``roughness_rad`` is chosen: 0.2 for what is smooth at the millimetre, 0.6 for stones and chips.
- ``friction`` is for rubber. Tables for tyres have, dry, 0.75-0.90 for concrete, 0.65-0.80 for asphalt, 0.60-0.70 for
  crushed stone, 0.50-0.60 for earth, and 0.15-0.25 for wet earth, 0.20 for wet grass (Noon 1994, and a table of a
  dealer in tyres). Concrete and asphalt are at the upper ends, because a robot is slow; gravel and rock 0.60-0.65;
  dry turf and sand as earth; mulch 0.45 and mud 0.30 are chosen.
- ``stiffness_npm`` and ``damping_nspm`` are chosen so that a foot that carries 100 N sinks 1 mm or less into concrete,
  4 mm into gravel, 1 cm into sand, 1.2 cm into mulch and 5 cm into mud, about critically damped for 10 kg a leg.
- ``drag_per_m`` is chosen: tall grass slows a robot noticeably (0.2), a bush stops it within a step or two (1.6).
- ``relief_m`` and ``stone_m`` are chosen by eye: a float-finished path 2 mm, sand 1.5 cm, a rock bed stones of 14 cm.
"""

import numpy as np
from jaxtyping import Float32

from navtool.pipeline.arrays import Array
from navtool.sim.errors import SimError
from navtool.sim.world.surface import Surface, TerrainGroup

_STABLE, _GRANULAR, _POOR = TerrainGroup.stable, TerrainGroup.granular, TerrainGroup.poor_foothold
_RESISTANT, _MUD = TerrainGroup.high_resistance, TerrainGroup.mud

GROUND: tuple[Surface, ...] = (
    Surface(
        name="concrete",
        group=_STABLE,
        colour=(0.40, 0.39, 0.36),
        contrast=0.10,
        reflectivity=0.30,
        roughness_rad=0.30,
        friction=0.90,
        stiffness_npm=2.0e5,
        damping_nspm=1.2e3,
        relief_m=0.002,
    ),
    Surface(
        name="asphalt",
        group=_STABLE,
        colour=(0.105, 0.105, 0.11),
        contrast=0.25,
        reflectivity=0.17,
        roughness_rad=0.45,
        friction=0.80,
        stiffness_npm=1.5e5,
        damping_nspm=1.2e3,
        relief_m=0.004,
    ),
    Surface(
        name="sand",
        group=_GRANULAR,
        colour=(0.50, 0.41, 0.28),
        contrast=0.12,
        reflectivity=0.50,
        roughness_rad=0.40,
        friction=0.50,
        stiffness_npm=1.0e4,
        damping_nspm=6.0e2,
        drag_per_m=0.05,
        relief_m=0.015,
    ),
    Surface(
        name="gravel",
        group=_GRANULAR,
        colour=(0.32, 0.30, 0.275),
        contrast=0.35,
        reflectivity=0.30,
        roughness_rad=0.60,
        friction=0.60,
        stiffness_npm=2.5e4,
        damping_nspm=8.0e2,
        relief_m=0.012,
        stone_m=0.03,
    ),
    Surface(
        name="mulch",
        group=_GRANULAR,
        colour=(0.17, 0.10, 0.065),
        contrast=0.45,
        reflectivity=0.25,
        roughness_rad=0.60,
        friction=0.45,
        stiffness_npm=8.0e3,
        damping_nspm=5.0e2,
        drag_per_m=0.03,
        relief_m=0.018,
    ),
    Surface(
        name="rock_bed",
        group=_POOR,
        colour=(0.29, 0.275, 0.25),
        contrast=0.30,
        reflectivity=0.30,
        roughness_rad=0.50,
        friction=0.65,
        stiffness_npm=1.5e5,
        damping_nspm=1.2e3,
        relief_m=0.025,
        stone_m=0.14,
    ),
    Surface(
        name="grass",
        group=_RESISTANT,
        colour=(0.085, 0.125, 0.035),
        contrast=0.35,
        reflectivity=0.50,
        roughness_rad=0.60,
        friction=0.55,
        stiffness_npm=2.0e4,
        damping_nspm=8.0e2,
        drag_per_m=0.04,
        relief_m=0.018,
    ),
    Surface(
        name="mud",
        group=_MUD,
        colour=(0.10, 0.075, 0.05),
        contrast=0.22,
        reflectivity=0.10,
        roughness_rad=0.40,
        friction=0.30,
        stiffness_npm=2.0e3,
        damping_nspm=4.0e2,
        drag_per_m=0.25,
        relief_m=0.020,
    ),
)
"""What a region of the ground can be made of."""

THINGS: tuple[Surface, ...] = (
    Surface(name="bark", colour=(0.125, 0.10, 0.075), contrast=0.40, reflectivity=0.38, roughness_rad=0.50),
    Surface(name="twig", colour=(0.11, 0.085, 0.055), contrast=0.30, reflectivity=0.35, roughness_rad=0.40),
    Surface(name="leaf", colour=(0.075, 0.14, 0.03), contrast=0.35, reflectivity=0.48, pliable=True, drag_per_m=0.05),
    Surface(
        name="bush_leaf",
        group=_RESISTANT,
        colour=(0.045, 0.095, 0.025),
        contrast=0.35,
        reflectivity=0.48,
        drag_per_m=1.6,
    ),
    Surface(
        name="tall_grass",
        group=_RESISTANT,
        colour=(0.25, 0.25, 0.085),
        contrast=0.35,
        reflectivity=0.40,
        pliable=True,
        drag_per_m=0.2,
    ),
    Surface(name="rock", group=_POOR, colour=(0.27, 0.26, 0.24), contrast=0.30, reflectivity=0.36, roughness_rad=0.50),
    Surface(name="brick", colour=(0.33, 0.15, 0.10), contrast=0.22, reflectivity=0.38, roughness_rad=0.35),
    Surface(name="plaster", colour=(0.64, 0.62, 0.57), contrast=0.05, reflectivity=0.70, roughness_rad=0.20),
    Surface(name="steel", colour=(0.38, 0.39, 0.40), contrast=0.10, reflectivity=0.40, roughness_rad=0.40),
    Surface(
        name="glass",
        colour=(0.02, 0.025, 0.025),
        contrast=0.0,
        reflectivity=0.0,
        roughness_rad=0.0,
        transmittance=0.85,
        specular=0.08,
    ),
    Surface(
        name="bead",
        colour=(0.42, 0.25, 0.12),
        contrast=0.30,
        reflectivity=0.30,
        roughness_rad=0.20,
        pliable=True,
        drag_per_m=0.03,
    ),
)
"""What stands on the ground can be made of."""

SURFACES: tuple[Surface, ...] = GROUND + THINGS
"""All surfaces; the position of one in this table is its number."""

_NUMBERS = {surface.name: number for number, surface in enumerate(SURFACES)}


def surface_number(name: str) -> int:
    """The number of a surface.

    Raises:
        SimError: There is no surface of that name.
    """
    if name not in _NUMBERS:
        raise SimError(f"there is no surface {name!r}", cure=f"known are {', '.join(_NUMBERS)}")
    return _NUMBERS[name]


def surface_values(field: str) -> Float32[Array, " surfaces"]:
    """One numeric field of all surfaces, by number."""
    return np.array([getattr(surface, field) for surface in SURFACES], np.float32)
