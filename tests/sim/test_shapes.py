import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from navtool.pipeline.arrays import Array
from navtool.sim.shapes import Box, Cylinder, Ellipsoid, Shape

SHAPES = st.one_of(
    st.builds(Cylinder, st.floats(-3, 3), st.floats(-3, 3), st.floats(0.1, 2), st.floats(0.5, 3)),
    st.builds(Ellipsoid, st.floats(-3, 3), st.floats(-3, 3), st.floats(0, 2), st.floats(0.2, 2), st.floats(0.2, 2)),
    st.builds(
        Box,
        st.floats(-3, 3),
        st.floats(-3, 3),
        st.floats(0.2, 2),
        st.floats(0.2, 2),
        st.floats(0.3, 2),
        st.floats(-4, 4),
    ),
)


def is_inside(shape: Shape, points: Array) -> Array:
    """Membership by the bodies' definitions, in float64."""
    x, y, z = points
    match shape:
        case Cylinder():
            inside = (np.hypot(x - shape.x, y - shape.y) <= shape.radius) & (z >= 0) & (z <= shape.height)
        case Ellipsoid():
            flat = ((x - shape.x) ** 2 + (y - shape.y) ** 2) / shape.radius**2
            inside = flat + ((z - shape.z) / shape.half_height) ** 2 <= 1
        case Box():
            turned = np.exp(-1j * shape.yaw_rad) * ((x - shape.x) + 1j * (y - shape.y))
            inside = (
                (np.abs(turned.real) <= shape.half_length)
                & (np.abs(turned.imag) <= shape.half_width)
                & (z >= 0)
                & (z <= shape.height)
            )
    return np.asarray(inside)


def rays(seed: int, count: int = 40) -> tuple[Array, Array]:
    rng = np.random.default_rng(seed)
    origin = rng.uniform(-6, 6, (3, count)).astype(np.float32)
    aim = rng.uniform(-3, 3, (3, count)).astype(np.float32) + np.array([[0], [0], [1]], np.float32)
    return origin, aim - origin


@settings(max_examples=60, deadline=None)
@given(SHAPES, st.integers(0, 10**6))
def test_a_span_holds_exactly_the_points_inside(shape: Shape, seed: int) -> None:
    origin, direction = rays(seed)
    span = shape.span(origin, direction)
    moments = np.linspace(-1, 3, 400)
    points = origin[:, :, None] + direction[:, :, None].astype(np.float64) * moments
    inside = is_inside(shape, points)
    margin = 2e-3
    surely = (moments > span.enter[:, None] + margin) & (moments < span.leave[:, None] - margin)
    maybe = (moments >= span.enter[:, None] - margin) & (moments <= span.leave[:, None] + margin)
    assert inside[surely].all()
    assert not inside[~maybe].any()


@settings(max_examples=60, deadline=None)
@given(SHAPES, st.integers(0, 10**6))
def test_normals_have_unit_length_and_point_out_of_the_body(shape: Shape, seed: int) -> None:
    origin, direction = rays(seed)
    span = shape.span(origin, direction)
    met = (span.enter < span.leave - 1e-2) & (origin[2] + span.enter * direction[2] > 1e-2)  # nothing from below
    surface = origin[:, met] + span.enter[met] * direction[:, met]
    normals = shape.normal(surface)
    assert np.linalg.norm(normals, axis=0) == pytest.approx(np.ones(met.sum()), abs=1e-3)
    assert ((normals * direction[:, met]).sum(axis=0) <= 1e-2 * np.linalg.norm(direction[:, met], axis=0)).all()


def outline(shape: Shape) -> Array:
    """Points along the outline seen from above, (2, n)."""
    if isinstance(shape, Box):
        corners = np.array([1 + 1j, -1 + 1j, -1 - 1j, 1 - 1j, 1 + 1j])
        corners = np.exp(1j * shape.yaw_rad) * (corners.real * shape.half_length + 1j * corners.imag * shape.half_width)
        points = np.interp(np.linspace(0, 4, 4001), np.arange(5), corners) + shape.x + 1j * shape.y
    else:
        points = shape.radius * np.exp(1j * np.linspace(0, 2 * np.pi, 4001)) + shape.x + 1j * shape.y
    return np.stack([points.real, points.imag])


@settings(max_examples=60, deadline=None)
@given(SHAPES, st.integers(0, 10**6))
def test_clearance_is_the_signed_distance_to_the_outline(shape: Shape, seed: int) -> None:
    xy = np.random.default_rng(seed).uniform(-6, 6, (2, 30))
    distance = np.hypot(*(xy[:, :, None] - outline(shape)[:, None, :])).min(axis=1)
    level = np.full(30, shape.centre[2])
    inside = is_inside(shape, np.concatenate([xy, level[None]]))
    assert shape.clearance(xy) == pytest.approx(np.where(inside, -distance, distance), abs=4e-3)


def test_bounds_enclose_the_body() -> None:
    rng = np.random.default_rng(1)
    for shape in (Cylinder(1.0, 2.0, 0.4, 2.0), Ellipsoid(-1.0, 0.0, 0.3, 0.8, 0.5), Box(0.0, 1.0, 2.0, 0.3, 1.0, 0.7)):
        points = rng.uniform(-4, 4, (3, 20000))
        inside = points[:, is_inside(shape, points)]
        offset = np.abs(inside - np.array(shape.centre)[:, None])
        assert inside.shape[1] > 20
        assert (offset <= np.array(shape.half_extent)[:, None] + 1e-9).all()
