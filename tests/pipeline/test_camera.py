"""The camera model: OpenCV as the oracle, round trips, and what the lens cannot see."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from navtool.pipeline.geometry.camera import CameraModel

Floats = NDArray[np.float64]

IDEAL = CameraModel(640, 480, 420.0, 430.0, 315.0, 247.0)
LENSES = {
    "none": IDEAL,
    "plumb_bob of 4": replace(IDEAL, distortion_model="plumb_bob", distortion=(-0.28, 0.07, 0.001, -0.0007)),
    "plumb_bob of 5": replace(IDEAL, distortion_model="plumb_bob", distortion=(-0.33, 0.14, 0.0004, 0.0006, -0.03)),
    "barrel": replace(IDEAL, distortion_model="plumb_bob", distortion=(-0.3, 0.0, 0.0005, 0.0, 0.0)),
    "pincushion": replace(IDEAL, distortion_model="plumb_bob", distortion=(0.2, 0.05, 0.0, 0.0, 0.01)),
    "rational_polynomial": replace(
        IDEAL,
        distortion_model="rational_polynomial",
        distortion=(0.55, -2.4, 0.0003, -0.0004, 1.4, 0.43, -2.25, 1.3),
    ),
    "plumb_bob of 8": replace(
        IDEAL, distortion_model="plumb_bob", distortion=(0.55, -2.4, 0.0003, -0.0004, 1.4, 0.43, -2.25, 1.3)
    ),
    "thin prism": replace(
        IDEAL,
        distortion_model="rational_polynomial",
        distortion=(0.55, -2.4, 0.0003, -0.0004, 1.4, 0.43, -2.25, 1.3, 0.002, -0.001, 0.003, 0.0005),
    ),
    "tilted sensor": replace(
        IDEAL,
        distortion_model="rational_polynomial",
        distortion=(-0.28, 0.07, 0.001, -0.0007, 0.0, 0.0, 0.0, 0.0, 0.001, 0.0, -0.002, 0.0, 0.02, -0.03),
    ),
    "equidistant": replace(
        IDEAL, fx=200.0, fy=202.0, distortion_model="equidistant", distortion=(-0.02, 0.01, -0.006, 0.001)
    ),
}


@pytest.fixture(params=sorted(LENSES))
def camera(request: pytest.FixtureRequest) -> CameraModel:
    return LENSES[request.param]


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(11)


def by_opencv(camera: CameraModel, points: Floats) -> Floats:
    zero, coefficients = np.zeros(3), np.array(camera.distortion)
    if camera.distortion_model == "equidistant":
        pixels, _ = cv2.fisheye.projectPoints(points[:, None], zero, zero, camera.matrix(), coefficients)
    else:
        pixels, _ = cv2.projectPoints(points, zero, zero, camera.matrix(), coefficients if len(coefficients) else None)
    return np.asarray(pixels, np.float64).reshape(-1, 2)


def points_within(camera: CameraModel, rng: np.random.Generator, share: float) -> Floats:
    """Points in front of the camera within a share of its field, at most 63 degrees from the axis."""
    radius = rng.uniform(0, share * min(camera.max_radius, 2.0), 300)
    angle, depth = rng.uniform(0, 2 * np.pi, 300), rng.uniform(0.2, 80.0, 300)
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), np.ones(300)]) * depth[:, None]


def test_projection_agrees_with_opencv(camera: CameraModel, rng: np.random.Generator) -> None:
    points = points_within(camera, rng, 0.95)
    pixels, in_front = camera.project(points)
    assert in_front.all()
    np.testing.assert_allclose(pixels, by_opencv(camera, points), atol=1e-8)


def test_rays_lead_back_to_the_points(camera: CameraModel, rng: np.random.Generator) -> None:
    points = points_within(camera, rng, 0.9)
    rays = camera.rays(camera.project(points).pixels)
    assert rays.valid.all()
    np.testing.assert_allclose(rays.directions, points / points[:, 2:], atol=1e-6)


def test_a_ray_of_every_pixel_projects_onto_it(camera: CameraModel) -> None:
    pixels = np.stack(np.meshgrid(np.arange(0.0, 640, 13), np.arange(0.0, 480, 13)), axis=-1).reshape(-1, 2)
    directions, valid = camera.rays(pixels)
    assert valid.mean() > 0.75  # some lenses leave the corners dark
    assert np.isnan(directions[~valid]).all()
    np.testing.assert_allclose(camera.project(directions[valid]).pixels, pixels[valid], atol=1e-5)


def test_what_is_behind_or_beyond_the_field_has_no_pixel(camera: CameraModel, rng: np.random.Generator) -> None:
    behind = rng.normal(size=(50, 3)) * 5
    behind[:, 2] = -np.abs(behind[:, 2])
    pixels, in_front = camera.project(np.vstack([behind, [[1.0, 1.0, 0.0], [0.0, 0.0, 0.0]]]))
    assert not in_front.any()
    assert np.isnan(pixels).all()


def test_the_field_ends_where_the_radius_stops_growing(camera: CameraModel) -> None:
    limit = min(camera.max_radius, 50.0)
    radius = np.linspace(0, limit * (1 - 1e-9), 2000)
    points = np.column_stack([radius, np.zeros_like(radius), np.ones_like(radius)])
    undistorted_tangentially = replace(camera, distortion=_radial_alone(camera))
    assert (np.diff(undistorted_tangentially.project(points).pixels[:, 0]) > 0).all()
    if np.isfinite(camera.max_radius):
        just_beyond = np.array([[camera.max_radius * 1.001, 0.0, 1.0]])
        assert not camera.project(just_beyond).in_front.any()


def test_barrel_lens_does_not_fold_the_side_into_the_image() -> None:
    # The polynomial brings a point at 63 degrees back into the image, on the other side.
    camera = LENSES["barrel"]
    side = np.array([[4.0, 0.0, 2.0]])
    assert abs(by_opencv(camera, side)[0, 0] - camera.cx) < 320
    assert not camera.project(side).in_front.any()


@settings(deadline=None)
@given(width=st.integers(8, 2000), height=st.integers(8, 2000))
def test_scaling_keeps_places_in_the_picture(width: int, height: int) -> None:
    camera = LENSES["plumb_bob of 5"]
    scaled = camera.scaled_to(width, height)
    points = np.array([[0.3, -0.2, 1.0], [-0.4, 0.3, 1.1], [0.0, 0.0, 3.0]])
    whole, small = camera.project(points).pixels, scaled.project(points).pixels
    # Shares of the picture, from the outer edge of its first pixel.
    np.testing.assert_allclose((small + 0.5) / (width, height), (whole + 0.5) / (640, 480), atol=1e-12)
    back = scaled.scaled_to(640, 480)
    np.testing.assert_allclose(back.matrix(), camera.matrix(), atol=1e-9)


def test_scaling_agrees_with_resized_pictures() -> None:
    picture = np.zeros((480, 640), np.float32)
    picture[200:216, 400:432] = 1.0
    small = cv2.resize(picture, (160, 120), interpolation=cv2.INTER_AREA)
    rows, columns = np.indices(small.shape)
    centre_small = np.array([(columns * small).sum(), (rows * small).sum()]) / small.sum()
    camera = replace(IDEAL, cx=415.5, cy=207.5)  # the principal point is the patch's centre
    scaled = camera.scaled_to(160, 120)
    np.testing.assert_allclose([scaled.cx, scaled.cy], centre_small, atol=1e-5)


def test_far_points_keep_their_pixels_in_float32(rng: np.random.Generator) -> None:
    points = points_within(IDEAL, rng, 0.5)
    np.testing.assert_allclose(IDEAL.project(points.astype(np.float32)).pixels, IDEAL.project(points).pixels, atol=1e-3)


def test_no_points_and_no_pixels() -> None:
    assert IDEAL.project(np.zeros((0, 3))).pixels.shape == (0, 2)
    assert IDEAL.rays(np.zeros((0, 2))).valid.shape == (0,)


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"width": 0}, "0x480"),
        ({"fx": 0.0}, "fx=0.0"),
        ({"cy": float("nan")}, "cy=nan"),
        ({"distortion_model": "fisheye9"}, "plumb_bob, rational_polynomial"),
        ({"distortion_model": "plumb_bob", "distortion": (0.1, 0.2, 0.3)}, "3 coefficients; expected 4 to 14"),
        ({"distortion": (0.1, 0.0, 0.0, 0.0)}, "'none' has 4 coefficients"),
        ({"distortion_model": "plumb_bob", "distortion": (0.1, float("inf"), 0.0, 0.0)}, "finite"),
    ],
)
def test_bad_intrinsics_are_reported(changes: dict[str, object], told: str) -> None:
    with pytest.raises(ValueError, match=told):
        replace(IDEAL, **changes)  # type: ignore[arg-type] # each value has its field's type or is the point


def _radial_alone(camera: CameraModel) -> tuple[float, ...]:
    if camera.distortion_model == "equidistant" or not camera.distortion:
        return camera.distortion
    k1, k2, _, _, *rest = camera.distortion
    return (k1, k2, 0.0, 0.0, *rest[:4])
