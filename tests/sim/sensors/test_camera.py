from collections.abc import Callable
from dataclasses import replace

import cv2
import numpy as np
import pytest

from navtool.configs.schema import config_folder
from navtool.pipeline.arrays import Array
from navtool.pipeline.geometry.camera import CameraModel
from navtool.pipeline.geometry.transforms import transform_from_xyz_rpy
from navtool.pipeline.image_reliability import ImageReliabilityConfig, count_corners, image_reliability
from navtool.sim.sensors.camera import Camera, Picture, PoseAt
from navtool.sim.sensors.camera_config import CameraConfig
from navtool.sim.sensors.shader import SKY, Shader
from navtool.sim.world.mesh import TriangleMesh
from navtool.sim.world.place import World, make_world
from navtool.sim.world.primitives import box
from navtool.sim.world.ray_scene import RayScene
from navtool.sim.world.scenario import LightConfig, Scatter, ScenarioConfig, load_scenario
from navtool.sim.world.surfaces import surface_number

type Wall = Callable[..., TriangleMesh]
type WorldOf = Callable[..., World]

MODEL = CameraModel(160, 120, 110.0, 110.0, 79.5, 59.5, "plumb_bob", (-0.25, 0.06, 0.001, -0.0005, 0.0))
OPTICAL = np.array([[0.0, 0, 1, 0], [-1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 0, 1]])
HEIGHT_M = 0.6
CLEAN = CameraConfig(vignetting=0.0, blur_px=0.0)


def moving(speed_mps: float = 0.0, turn_radps: float = 0.0, pitch_rad: float = 0.0, x_m: float = 0.0) -> PoseAt:
    def pose_at(time_s: Array) -> Array:
        zero = np.zeros_like(time_s)
        xyz = np.stack([x_m + speed_mps * time_s, zero, zero + HEIGHT_M], axis=-1)
        rpy = np.stack([zero, zero + pitch_rad, turn_radps * time_s], axis=-1)
        return np.asarray(transform_from_xyz_rpy(xyz, rpy) @ OPTICAL)

    return pose_at


_SHADERS: list[tuple[World, Shader]] = []


def shader_of(world: World) -> Shader:
    """The shader of a world; made once."""
    for known, shader in _SHADERS:
        if known is world:
            return shader
    _SHADERS.append((world, Shader(world, RayScene(world.mesh))))
    return _SHADERS[-1][1]


def take(
    world: World, pose_at: PoseAt | None = None, config: CameraConfig = CLEAN, lux: float = 2e4, seed: int = 0
) -> Picture:
    pose_at = pose_at if pose_at is not None else moving()
    return Camera(MODEL, config).picture(shader_of(world), pose_at, lux, np.random.default_rng(seed))


def test_depth_is_that_of_planes(world_of: WorldOf, wall_at: Wall) -> None:
    picture = take(world_of(wall_at(5.0, "brick", z=(0.0, 3.0))))
    wall = picture.surface == surface_number("brick")
    assert wall.sum() > 1000
    assert picture.depth_m[wall] == pytest.approx(np.full(wall.sum(), 5.0), abs=1e-3)
    ground = picture.surface == surface_number("concrete")
    rows, columns = np.nonzero(ground)
    rays = MODEL.rays(np.column_stack([columns, rows]).astype(np.float64)).directions
    assert picture.depth_m[ground] == pytest.approx(HEIGHT_M / rays[:, 1], rel=1e-3)
    assert np.isinf(picture.depth_m[picture.surface == SKY]).all()


def test_what_is_seen_lies_where_the_lens_projects_it(world_of: WorldOf, wall_at: Wall) -> None:
    picture = take(world_of(wall_at(4.0, "brick", y=(-0.7, 1.1), z=(0.2, 1.5))))
    rng = np.random.default_rng(0)
    y, z = rng.uniform(-2.0, 2.0, 500), rng.uniform(0.05, 2.0, 500)
    found = MODEL.project(np.stack([-y, HEIGHT_M - z, np.full(500, 4.0)], axis=1))
    u, v = np.round(found.pixels).astype(int).T
    edge = np.minimum.reduce([abs(y + 0.7), abs(y - 1.1), abs(z - 0.2), abs(z - 1.5)]) < 0.04
    kept = ~edge & (u >= 0) & (u < MODEL.width) & (v >= 0) & (v < MODEL.height)
    inside = (y > -0.7) & (y < 1.1) & (z > 0.2) & (z < 1.5)
    assert kept.sum() > 250
    assert ((picture.surface[v, u] == surface_number("brick")) == inside)[kept].all()


def edge_width(picture: Picture) -> float:
    """Columns over which brightness passes from a dark wall to a bright one, between 10 and 90 %."""
    rows = picture.rgb[50:58, 20:140].astype(np.float64).mean(axis=(0, 2))
    low, high = rows[:30].mean(), rows[-30:].mean()
    share = (rows - low) / (high - low)
    return float(np.argmax(share > 0.9) - np.argmax(share > 0.1))


@pytest.fixture(scope="module")
def edge_world(world_of: WorldOf, wall_at: Wall) -> World:
    dark = wall_at(4.0, "asphalt", y=(0.0, 20.0), z=(-1.0, 8.0))
    bright = wall_at(4.0, "plaster", y=(-20.0, 0.0), z=(-1.0, 8.0))
    return world_of(dark, bright, light=LightConfig(sun_share=0.0))


@pytest.mark.parametrize("turn", [0.5, 1.0, 2.0])
def test_blur_is_as_wide_as_the_turn_during_the_exposure(turn: float, edge_world: World) -> None:
    config = replace(CLEAN, shutter_s=0.1, full_well=1e6, edge_rays=0)
    picture = take(edge_world, moving(turn_radps=turn), config, lux=3000.0)
    expected = 0.8 * MODEL.fx * turn * 0.1
    assert edge_width(picture) == pytest.approx(expected, abs=2.0 + 0.12 * expected)
    assert edge_width(take(edge_world, moving(), config, lux=3000.0)) <= 2


def test_what_is_near_blurs_more_when_the_camera_moves_sideways(world_of: WorldOf) -> None:
    def sideways(time_s: Array) -> Array:
        poses = np.array(moving()(time_s))
        poses[:, 1, 3] += 1.5 * time_s
        return poses

    world = world_of(light=LightConfig(sun_share=0.0), ground="gravel")
    config = replace(CLEAN, shutter_s=0.06, full_well=1e6)
    still, moved = (take(world, pose, config, lux=3000.0) for pose in (moving(), sideways))
    sharpness = [
        np.abs(np.diff(picture.rgb.astype(np.float64).mean(axis=2), axis=1)).mean(axis=1) for picture in (still, moved)
    ]
    near, far = slice(100, 118), slice(64, 68)
    assert sharpness[1][near].mean() < 0.6 * sharpness[0][near].mean()
    assert sharpness[1][far].mean() > 0.6 * sharpness[0][far].mean()


def test_what_stands_in_the_sun_throws_a_shadow(world_of: WorldOf) -> None:
    block = box(0.6, 0.6, 1.5, 0.0, surface_number("brick")).moved(4.0, 0.0, 0.0)
    light = LightConfig(sun_share=0.8)
    bare, shaded = (shader_of(world_of(*meshes, light=light)) for meshes in ((), (block,)))
    eye = np.array([4.0, 1.3, 1.0], np.float32)  # the sun stands at -y: the shadow falls to +y
    down = np.array([[0.0], [0.0], [-1.0]], np.float32)
    in_sun, in_shade = (float(shader.see(eye, down, 0.01).radiance.mean()) for shader in (bare, shaded))
    assert in_shade < 0.45 * in_sun
    other = np.array([4.0, -1.3, 1.0], np.float32)
    assert float(shaded.see(other, down, 0.01).radiance.mean()) > 0.8 * in_sun


def test_a_level_white_sheet_in_the_open_has_brightness_one(world_of: WorldOf) -> None:
    shader = shader_of(world_of())
    rng = np.random.default_rng(0)
    rays = np.stack([rng.normal(0, 0.3, 4000), rng.normal(0, 0.3, 4000), np.full(4000, -1.0)]).astype(np.float32)
    seen = shader.see(np.array([0.0, 0.0, 2.0], np.float32), rays, 0.01)
    colour = np.array([0.40, 0.39, 0.36])
    assert seen.radiance.mean(axis=1) / colour == pytest.approx(np.ones(3), abs=0.12)


def test_glass_shows_what_is_behind_it(world_of: WorldOf, wall_at: Wall) -> None:
    wall = wall_at(6.0, "brick", z=(0.0, 4.0))
    bare = take(world_of(wall))
    glazed = take(world_of(wall, wall_at(3.0, "glass", z=(0.0, 4.0))))
    pane = glazed.surface == surface_number("glass")
    assert pane.sum() > 0.4 * pane.size
    difference = np.abs(glazed.rgb.astype(float) - bare.rgb.astype(float))[pane].mean()
    assert 0 < difference < 25
    assert glazed.depth_m[pane] == pytest.approx(np.full(pane.sum(), 3.0), abs=1e-3)


@pytest.fixture(scope="module")
def grove() -> World:
    return make_world(
        ScenarioConfig(
            name="grove",
            side_m=24.0,
            cell_m=0.2,
            course_m=10.0,
            trees=Scatter(count=5),
            bushes=Scatter(count=5, gap_m=0.8),
            grass_patches=Scatter(count=5, gap_m=0.0),
        ),
        0,
    )


def test_reliability_falls_with_light_and_with_motion(grove: World) -> None:
    def reliability(lux: float, pose_at: PoseAt) -> tuple[float, float]:
        shader, config = shader_of(grove), CameraConfig()
        model = MODEL.scaled_to(320, 240)
        picture = Camera(model, config).picture(shader, pose_at, lux, np.random.default_rng(0))
        found = image_reliability(picture.rgb, ImageReliabilityConfig())
        return found.brightness, found.image

    pose = moving(x_m=-5.0)
    day, evening, night = (reliability(lux, pose) for lux in (3e4, 12.0, 0.5))
    assert day[0] > evening[0] > night[0]
    assert day[1] > evening[1] > night[1]
    shaken = reliability(200.0, moving(x_m=-5.0, turn_radps=1.5))
    assert shaken[1] < reliability(200.0, pose)[1]


def test_corners_fall_as_the_yaw_rate_rises(grove: World) -> None:
    camera, corners = Camera(MODEL.scaled_to(320, 240)), []
    for rate in (0.0, 0.4, 0.8, 1.6):
        pose_at = moving(x_m=-5.0, turn_radps=rate)
        rgb = camera.picture(shader_of(grove), pose_at, 200.0, np.random.default_rng(0)).rgb
        corners.append(count_corners(np.asarray(cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY), np.uint8), 30))
    assert corners == sorted(corners, reverse=True)
    assert corners[-1] < 0.3 * corners[0] > 30


def test_the_dark_scenario_is_less_reliable_than_the_same_place_at_noon() -> None:
    dark = load_scenario(config_folder() / "scenario" / "graspe_4.yaml")
    world = make_world(dark, 0)
    shader, camera = Shader(world, RayScene(world.mesh)), Camera(MODEL.scaled_to(320, 240))
    x, y = world.start_m
    z = float(world.ground.height_at(np.array([x]), np.array([y]))[0])

    def pose_at(time_s: Array) -> Array:
        poses = np.array(moving(speed_mps=0.5)(time_s))
        poses[:, :3, 3] += x, y, z
        return poses

    found = []
    for lux in (1e5, dark.light.illuminance_lux):
        picture = camera.picture(shader, pose_at, lux, np.random.default_rng(0))
        found.append(image_reliability(picture.rgb, ImageReliabilityConfig()))
    assert found[1].brightness < 0.8 * found[0].brightness
    assert found[1].image < 0.8 * found[0].image


def test_every_pixel_is_a_surface_or_the_sky(grove: World) -> None:
    picture = take(grove, moving(x_m=-5.0))
    assert set(np.unique(picture.surface)) <= {*range(19), SKY}
    assert ((picture.surface == SKY) == np.isinf(picture.depth_m)).all()
    assert np.nanmin(picture.depth_m) > 0
    for name in ("grass", "bark", "leaf"):
        assert (picture.surface == surface_number(name)).any(), name


def test_equal_generators_give_equal_pictures(grove: World) -> None:
    one, two, other = (take(grove, moving(0.8, 0.4, x_m=-5.0), CameraConfig(), seed=seed) for seed in (1, 1, 2))
    assert one.rgb.tobytes() == two.rgb.tobytes()
    assert one.surface.tobytes() == two.surface.tobytes()
    assert one.rgb.tobytes() != other.rgb.tobytes()


@pytest.mark.parametrize("share", [0.1, 0.4, 1.0])
def test_dirt_covers_its_share_and_hides_what_is_behind_it(share: float, grove: World) -> None:
    shader, pose = shader_of(grove), moving(x_m=-5.0)
    fixed = CameraConfig(shutter_s=1e-3, read_noise=0.0)
    cameras = [Camera(MODEL, replace(fixed, dirt_share=dirt)) for dirt in (0.0, share)]
    clean, dirty = (camera.picture(shader, pose, 2e4, np.random.default_rng(0)) for camera in cameras)
    cover = cameras[1].dirt[..., 0]
    assert cover.mean() == pytest.approx(share, abs=0.08)
    detail = [np.abs(np.diff(picture.rgb.astype(np.float64), axis=1)).mean(axis=2) for picture in (clean, dirty)]
    hidden, free = cover[:, 1:] > 0.9, cover[:, 1:] < 0.01
    if share > 0.2:
        assert detail[1][hidden].mean() < 0.6 * detail[0][hidden].mean()
    if free.any():
        assert detail[1][free] == pytest.approx(detail[0][free], abs=3.0)
    assert (dirty.surface == clean.surface).all(), "the truth is behind the dirt"
