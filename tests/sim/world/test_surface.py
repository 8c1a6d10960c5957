import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from navtool.pipeline.arrays import Array
from navtool.sim.errors import SimError
from navtool.sim.world.surface import TerrainGroup, returned_share
from navtool.sim.world.surfaces import GROUND, SURFACES, surface_number, surface_values

COSINES = np.linspace(0, 1, 101, dtype=np.float32)


def share(roughness: float, reflectivity: float = 0.5) -> Array:
    same = np.ones_like(COSINES)
    return returned_share(COSINES, same * np.float32(reflectivity), same * np.float32(roughness))


def test_a_smooth_surface_follows_lamberts_law() -> None:
    assert share(0.0) == pytest.approx(0.5 * COSINES, abs=1e-6)


@given(st.floats(0.0, 0.8))
def test_a_rough_surface_is_darker_face_on_and_brighter_at_grazing_incidence(roughness: float) -> None:
    found = share(roughness)
    assert found[-1] <= 0.5 + 1e-6
    assert found[5] >= 0.5 * COSINES[5] - 1e-6
    assert (found >= 0).all()
    assert (found <= 0.5 + 1e-6).all()


def test_the_side_of_the_normal_does_not_matter() -> None:
    ones = np.ones_like(COSINES)
    assert (returned_share(-COSINES, ones, ones) == returned_share(COSINES, ones, ones)).all()


def test_every_surface_conserves_energy_and_carries_a_robot() -> None:
    for surface in SURFACES:
        assert surface.reflectivity + surface.transmittance + surface.specular <= 1, surface.name
        assert all(0 < value < 1 for value in surface.colour), surface.name
        assert min(surface.friction, surface.stiffness_npm, surface.damping_nspm) > 0, surface.name
        assert surface.drag_per_m >= 0, surface.name


def test_each_of_the_papers_groups_has_ground() -> None:
    assert {surface.group for surface in GROUND} == set(TerrainGroup) - {TerrainGroup.none}


def test_softer_ground_sinks_more_and_grips_less() -> None:
    stiffness = surface_values("stiffness_npm")
    order = [surface_number(name) for name in ("concrete", "gravel", "sand", "mulch", "mud")]
    assert (np.diff(stiffness[order]) < 0).all()
    friction = surface_values("friction")
    assert friction[surface_number("concrete")] > friction[surface_number("sand")] > friction[surface_number("mud")]


def test_an_unknown_surface_is_named() -> None:
    with pytest.raises(SimError, match=r"lava"):
        surface_number("lava")
