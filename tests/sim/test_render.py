from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from navtool.pipeline.arrays import Array
from navtool.pipeline.geometry.transforms import apply_transform, invert_transform, transform_from_xyz_rpy
from navtool.sim.render import Camera, Exposure
from navtool.sim.rig import camera_model, mount
from navtool.sim.scene import BRICK, Material, Scene, Thing
from navtool.sim.shapes import Box, Cylinder

RED = Material((250.0, 0.0, 0.0), 0.0, 0.5)


def at(x: float, y: float, yaw: float) -> Array:
    pose: Array = transform_from_xyz_rpy(np.array([x, y, 0.0]), np.array([0.0, 0.0, yaw]))
    return pose @ mount("camera_front_optical")


def image(scene: Scene, pose: Array, *, width: int = 320, turn: float = 0.0, **exposure: float) -> Array:
    camera = Camera(camera_model(width))
    settings_ = Exposure(**{"noise": 0.0, **exposure})
    return camera.image(scene, pose, settings_, turn, np.random.default_rng(0)).astype(np.float64)


@pytest.mark.parametrize("width", [320, 640])
@pytest.mark.parametrize("spot", [(3.0, 0.0), (4.0, 1.5), (6.0, -2.5)])
def test_a_cylinder_stands_where_the_camera_model_projects_it(
    flat_scene: Callable[..., Scene], width: int, spot: tuple[float, float]
) -> None:
    pole = Cylinder(*spot, 0.08, 1.0)
    pose = at(0.3, 0.1, 0.05)
    rgb = image(flat_scene(Thing(pole, RED)), pose, width=width)
    seen = rgb[..., 0] > rgb[..., 1] + 60
    assert seen.any()
    line = np.linspace([*spot, 0.02], [*spot, 0.98], 50)
    pixels, in_front = camera_model(width).project(apply_transform(invert_transform(pose), line))
    assert in_front.all()
    rows, columns = np.nonzero(seen)
    slack = 1.5 * width / 320
    for u, v in pixels:
        beside = columns[np.abs(rows - v) <= 1]
        assert beside.mean() == pytest.approx(u, abs=slack)
    half_height = 0.08 / 3.0 * camera_model(width).fy
    assert rows.min() == pytest.approx(pixels[:, 1].min(), abs=slack + half_height)
    assert rows.max() == pytest.approx(pixels[:, 1].max(), abs=slack + half_height)


def test_the_nearer_of_two_bodies_is_seen(flat_scene: Callable[..., Scene]) -> None:
    near, far = Thing(Cylinder(3.0, 0.0, 0.2, 2.0), RED), Thing(Box(5.0, 0.0, 0.2, 3.0, 3.0, 0.0), BRICK)
    both, alone = (image(flat_scene(*things), at(0.0, 0.0, 0.0)) for things in ((far, near), (near,)))
    red = alone[..., 0] > alone[..., 1] + 60
    inner = (
        red & np.roll(red, 2, axis=1) & np.roll(red, -2, axis=1) & np.roll(red, 2, axis=0) & np.roll(red, -2, axis=0)
    )
    assert inner.sum() > 500
    assert both[inner] == pytest.approx(alone[inner], abs=1)


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10**6))
def test_each_body_is_drawn_within_its_window(place: Scene, seed: int) -> None:
    rng = np.random.default_rng(seed)
    pose = at(rng.uniform(-8, 8), rng.uniform(-8, 8), rng.uniform(-3, 3))
    camera = Camera(camera_model(160))
    origin = pose[:3, 3].astype(np.float32).reshape(3, 1, 1)
    rays = np.einsum("ij,jrc->irc", pose[:3, :3].astype(np.float32), camera._rays)
    windows = {id(thing): window for thing, window in camera._visible(place, pose)}
    with np.errstate(all="ignore"):
        for thing in place.things:
            span = thing.shape.span(origin, rays)
            outside = (span.enter < span.leave - 1e-3) & (span.enter > 0.03)
            if id(thing) in windows:
                outside[windows[id(thing)]] = False
            assert not outside.any()


def test_light_noise_and_motion_change_the_image_as_named(flat_scene: Callable[..., Scene], place: Scene) -> None:
    pose = at(0.0, 0.0, 0.4)
    bright = image(place, pose)
    assert image(place, pose, brightness=0.2).mean() == pytest.approx(0.2 * bright.mean(), rel=0.1)
    noisy = image(flat_scene(), pose, noise=4.0) - image(flat_scene(), pose)
    assert noisy.std() == pytest.approx(4.0, rel=0.1)
    blurred = image(place, pose, turn=0.8, shutter_s=0.05)
    assert np.abs(np.diff(blurred, axis=1)).mean() < 0.6 * np.abs(np.diff(bright, axis=1)).mean()
    assert image(place, pose, turn=0.8, shutter_s=0.0) == pytest.approx(bright), "a closed shutter freezes the turn"
    assert blurred.mean() == pytest.approx(bright.mean(), rel=0.02), "motion moves light, it does not make any"


def test_the_sky_is_above_the_horizon_and_the_ground_below(flat_scene: Callable[..., Scene]) -> None:
    rgb = image(flat_scene(), at(0.0, 0.0, 0.0))
    model = camera_model(320)
    horizon = model.cy - model.fy * np.tan(0.10)
    sky, ground = rgb[: int(horizon) - 8], rgb[int(horizon) + 12 :]
    assert (sky[..., 2] > sky[..., 0]).all()
    assert (ground[..., 0] > ground[..., 2]).all()


@pytest.mark.parametrize("wrong", [{"brightness": 0.0}, {"noise": -1.0}, {"shutter_s": -0.1}])
def test_an_exposure_out_of_range_is_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(ValueError, match="need 0 < brightness"):
        Exposure(**wrong)
