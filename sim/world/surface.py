"""What a surface is made of: how it looks, how it returns laser light, and how it carries and resists a robot."""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from jaxtyping import Float32

from navtool.pipeline.arrays import Array


class TerrainGroup(StrEnum):
    """AMCO's groups of terrain, with mud beside them; ``none`` is what nobody walks on."""

    stable = "stable"
    granular = "granular"
    poor_foothold = "poor_foothold"
    high_resistance = "high_resistance"
    mud = "mud"
    none = "none"


@dataclass(frozen=True, slots=True, kw_only=True)
class Surface:
    """One material. Where each kind of number comes from stands in ``navtool.sim.world.surfaces``."""

    name: str
    group: TerrainGroup = TerrainGroup.none
    colour: tuple[float, float, float]
    """Share of red, green and blue light that it scatters (linear, 0-1)."""
    contrast: float
    """Depth of its texture: relative standard deviation of the brightness, 0-1."""
    reflectivity: float
    """Share of 905 nm laser light that it scatters at normal incidence, 0-1."""
    roughness_rad: float = 0.3
    """Standard deviation of the slopes of its facets: how slowly its brightness falls with the incidence angle."""
    transmittance: float = 0.0
    """Share of 905 nm light that goes straight through, 0-1."""
    specular: float = 0.0
    """Share of 905 nm light that a smooth pane mirrors at normal incidence, 0-1."""
    pliable: bool = False
    """Bends out of a robot's way."""
    friction: float = 0.8
    """Coulomb's coefficient against a rubber foot or tyre."""
    stiffness_npm: float = 1.0e5
    """Normal force per metre that a foot of 20 cm2 sinks in, in newtons per metre."""
    damping_nspm: float = 1.0e3
    """Normal force per speed of sinking in, in newton seconds per metre."""
    drag_per_m: float = 0.0
    """Share of its speed that a body loses in each metre that it moves through it."""
    relief_m: float = 0.0
    """Standard deviation of the ground's height at wavelengths of a step and below, in metres."""
    stone_m: float = 0.0
    """Largest height of the single stones that stand out of the ground, in metres."""


def returned_share(
    incidence_cosine: Float32[Array, "*n"], reflectivity: Float32[Array, "*n"], roughness_rad: Float32[Array, "*n"]
) -> Float32[Array, "*n"]:
    r"""The share of a laser's light that comes back along the beam, relative to a white Lambertian plate facing it.

    .. math::
        \rho \, (A \cos\theta + B \sin^2\theta), \quad
        A = 1 - \frac{\sigma^2}{2 (\sigma^2 + 0.33)}, \quad B = \frac{0.45 \, \sigma^2}{\sigma^2 + 0.09}

    Lambert's law for sigma = 0; a rough surface stays brighter at grazing incidence, because a sensor at the light
    source sees the facets that face it. Reference: Oren and Nayar 1994, with source and viewer in one direction.

    Args:
        incidence_cosine: Cosine of the angle between beam and normal; the sign does not matter.
        reflectivity: rho, 0-1.
        roughness_rad: sigma, the standard deviation of the facets' slopes.
    """
    cosine = np.minimum(np.abs(incidence_cosine), np.float32(1.0))
    spread = roughness_rad * roughness_rad
    a = np.float32(1.0) - np.float32(0.5) * spread / (spread + np.float32(0.33))
    b = np.float32(0.45) * spread / (spread + np.float32(0.09))
    share: Array = reflectivity * (a * cosine + b * (np.float32(1.0) - cosine * cosine))
    return share
