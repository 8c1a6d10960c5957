from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from navtool.base.setting_error import SettingError
from navtool.configs.schema import config_folder
from navtool.pipeline.arrays import Array
from navtool.pipeline.geometry.transforms import apply_transform, transform_from_xyz_rpy
from navtool.sim.sensors.lidar import AIR, Cloud, Lidar
from navtool.sim.sensors.lidar_config import LidarConfig, Returns
from navtool.sim.world.mesh import TriangleMesh, make_mesh
from navtool.sim.world.place import make_world
from navtool.sim.world.primitives import sphere_points
from navtool.sim.world.ray_scene import RayScene
from navtool.sim.world.scenario import WeatherConfig, load_scenario
from navtool.sim.world.surface import returned_share
from navtool.sim.world.surfaces import SURFACES, surface_number

type Wall = Callable[..., TriangleMesh]
type SceneOf = Callable[..., RayScene]
type Standing = Callable[..., Array]
EXACT = LidarConfig(range_noise_m=0.0, range_step_m=1e-5)
HEIGHT_M = 0.7


def measured(
    scene: RayScene, poses: Array, config: LidarConfig = EXACT, seed: int = 0, weather: WeatherConfig | None = None
) -> Cloud:
    return Lidar(config, weather).measure(scene, poses, np.random.default_rng(seed))


def ranges(cloud: Cloud) -> Array:
    return np.asarray(np.linalg.norm(cloud.xyz.astype(np.float64), axis=1))


def azimuth(cloud: Cloud) -> Array:
    return np.asarray(np.arctan2(cloud.xyz[:, 1], cloud.xyz[:, 0]))


def test_the_vlp_16_has_its_rate_and_timing() -> None:
    config = LidarConfig()
    assert (config.rings, config.columns) == (16, 1808)
    assert config.column_time_s()[-1] + config.laser_time_s().max() == pytest.approx(0.0, abs=1e-12)
    assert np.diff(config.column_time_s()) == pytest.approx(np.full(1807, 55.296e-6))
    assert config.firing_order[:4] == [0, 8, 1, 9], "-15, 1, -13, 3 degrees"
    assert config.laser_time_s()[8] == pytest.approx(2.304e-6)


def test_level_ground_lies_at_the_analytic_range_of_each_ring(
    ground: TriangleMesh, scene_of: SceneOf, standing: Standing
) -> None:
    cloud = measured(scene_of(ground), standing(HEIGHT_M, EXACT.columns))
    for ring, elevation in enumerate(EXACT.elevation_rad):
        found = ranges(cloud)[cloud.ring == ring]
        if elevation > 0:
            assert not found.size, "the sky returns nothing"
        else:
            assert found.size == EXACT.columns
            assert found == pytest.approx(np.full(found.size, HEIGHT_M / np.sin(-elevation)), rel=2e-5)


def test_a_wall_lies_in_its_plane(wall_at: Wall, scene_of: SceneOf, standing: Standing) -> None:
    cloud = measured(scene_of(wall_at(7.0)), standing(HEIGHT_M, EXACT.columns))
    wide = np.abs(azimuth(cloud)) < 1.2
    assert cloud.xyz[wide][:, 0] == pytest.approx(np.full(wide.sum(), 7.0), abs=4e-4)


def test_a_sphere_is_met_where_its_equation_says(scene_of: SceneOf, standing: Standing) -> None:
    centre, radius = np.array([5.0, 0.5, HEIGHT_M]), 0.8
    vertices, triangles = sphere_points(5)
    sphere = make_mesh(vertices * radius + centre, triangles, surface_number("rock"))
    cloud = measured(scene_of(sphere), standing(HEIGHT_M, EXACT.columns))
    assert len(cloud.xyz) > 300
    towards = cloud.xyz / ranges(cloud)[:, None]
    offset = centre - [0, 0, HEIGHT_M]
    along = towards @ offset
    under = along**2 - (offset @ offset - radius**2)
    inner = under > 0.1
    assert ranges(cloud)[inner] == pytest.approx((along - np.sqrt(np.maximum(under, 0)))[inner], abs=1e-3)
    assert (under > -0.06).all(), "no point beside it"


def test_range_noise_has_its_deviation(wall_at: Wall, scene_of: SceneOf, standing: Standing) -> None:
    config = LidarConfig()
    cloud = measured(scene_of(wall_at(4.0)), standing(HEIGHT_M, config.columns), config)
    ahead = np.abs(azimuth(cloud)) < 0.6
    direction = cloud.xyz / ranges(cloud)[:, None]
    error = ranges(cloud) - 4.0 / direction[:, 0]
    assert error[ahead].std() == pytest.approx(config.range_noise_m, rel=0.06)
    assert error[ahead].mean() == pytest.approx(0.0, abs=0.001)
    steps = ranges(cloud) / config.range_step_m
    assert steps == pytest.approx(np.round(steps), abs=5e-3)


@pytest.mark.parametrize(("distance", "seen"), [(0.3, False), (0.45, False), (0.6, True)])
def test_the_sensor_is_blind_below_half_a_metre(
    distance: float, seen: bool, wall_at: Wall, scene_of: SceneOf, standing: Standing
) -> None:
    cloud = measured(scene_of(wall_at(distance)), standing(HEIGHT_M, EXACT.columns))
    assert (ranges(cloud) >= EXACT.min_range_m - 1e-3).all()
    assert bool((np.abs(azimuth(cloud)) < 0.1).any()) is seen


def test_intensity_follows_incidence_and_reflectivity(wall_at: Wall, scene_of: SceneOf, standing: Standing) -> None:
    config = replace(EXACT, full_scale=1.0)
    for name in ("concrete", "plaster", "asphalt"):
        cloud = measured(scene_of(wall_at(4.0, name)), standing(HEIGHT_M, config.columns), config)
        cosine = (4.0 / ranges(cloud)).astype(np.float32)
        surface = SURFACES[surface_number(name)]
        same = np.ones_like(cosine)
        wanted = 255 * returned_share(
            cosine, same * np.float32(surface.reflectivity), same * np.float32(surface.roughness_rad)
        )
        facing = cosine > 0.5
        assert cloud.intensity[facing] == pytest.approx(wanted[facing], abs=1.0)
        assert (cloud.surface == surface_number(name)).all()


@pytest.mark.parametrize("name", ["asphalt", "concrete", "mud"])
def test_a_surface_is_seen_as_far_as_its_light_carries(
    name: str, wall_at: Wall, scene_of: SceneOf, standing: Standing
) -> None:
    surface = SURFACES[surface_number(name)]
    one = np.ones(1, np.float32)
    share = returned_share(one, one * np.float32(surface.reflectivity), one * np.float32(surface.roughness_rad))[0]
    reach = EXACT.ten_percent_range_m * float(np.sqrt(share / 0.1))
    for distance, seen in ((0.97 * reach, True), (1.03 * reach, False)):
        cloud = measured(scene_of(wall_at(distance, name)), standing(HEIGHT_M, EXACT.columns))
        assert bool((np.abs(azimuth(cloud)) < 0.05).any()) is seen, distance


def test_dual_return_sees_both_sides_of_an_edge(wall_at: Wall, scene_of: SceneOf, standing: Standing) -> None:
    scene = scene_of(wall_at(6.0, y=(1.0, 300.0)), wall_at(14.0))
    config = replace(EXACT, returns=Returns.dual)
    cloud = measured(scene, standing(HEIGHT_M, config.columns), config)
    edge = np.abs(cloud.xyz[:, 1] / cloud.xyz[:, 0] - 1 / 6) < 0.004
    ahead = edge & (cloud.xyz[:, 0] > 0)
    times, uses = np.unique(cloud.time_s[ahead], return_counts=True)
    twice = times[uses == 2]
    assert len(twice) >= 16, "some beam of each ring is split"
    for time in twice:
        assert sorted(np.round(cloud.xyz[ahead & (cloud.time_s == time)][:, 0])) == [6.0, 14.0]
        split = cloud.intensity[ahead & (cloud.time_s == time)]
        assert split.sum() < 1.2 * 255
    single = measured(scene, standing(HEIGHT_M, EXACT.columns))
    last = measured(scene, standing(HEIGHT_M, EXACT.columns), replace(EXACT, returns=Returns.last))
    assert len(single.xyz) == len(last.xyz) == len(cloud.xyz) - len(twice)
    assert ranges(last).sum() > ranges(single).sum()


def test_glass_returns_weakly_near_normal_incidence_and_lets_the_beam_through(
    wall_at: Wall, scene_of: SceneOf, standing: Standing
) -> None:
    config = replace(EXACT, returns=Returns.dual)
    scene = scene_of(wall_at(3.0, "glass"), wall_at(7.0, "concrete"))
    cloud = measured(scene, standing(HEIGHT_M, config.columns), config)
    glass = cloud.surface == surface_number("glass")
    assert glass.sum() > 50
    angle = np.arccos(3.0 / ranges(cloud)[glass])
    assert angle.max() < np.radians(15)
    assert cloud.intensity[glass].max() < 0.5 * 255, "MIM: weak"
    strongest = int(np.argmax(cloud.intensity[glass]))
    assert angle[strongest] < np.radians(2)
    beyond = cloud.xyz[cloud.surface == surface_number("concrete")]
    assert beyond[:, 0] == pytest.approx(np.full(len(beyond), 7.0), abs=1e-3)
    oblique = np.abs(azimuth(cloud)) > np.radians(20)
    assert not (glass & oblique).any()
    bare = measured(
        scene_of(wall_at(7.0, "concrete")), standing(HEIGHT_M, config.columns), replace(config, full_scale=1.0)
    )
    paned = measured(scene, standing(HEIGHT_M, config.columns), replace(config, full_scale=1.0))
    share = paned.intensity[paned.surface == surface_number("concrete")].mean() / bare.intensity.mean()
    assert share == pytest.approx(SURFACES[surface_number("glass")].transmittance ** 2, abs=0.06)


def test_points_come_in_the_order_of_firing(ground: TriangleMesh, scene_of: SceneOf, standing: Standing) -> None:
    cloud = measured(scene_of(ground), standing(HEIGHT_M, EXACT.columns))
    assert (np.diff(cloud.time_s.astype(np.float64)) > -1e-9).all()
    assert cloud.time_s.max() <= 0
    assert cloud.time_s.min() > -0.1
    elevation = np.arcsin(cloud.xyz[:, 2] / ranges(cloud))
    assert elevation == pytest.approx(np.array(EXACT.elevation_rad)[cloud.ring], abs=1e-4)
    end = EXACT.column_time_s()[0]
    turned = -2 * np.pi * EXACT.rate_hz * (cloud.time_s.astype(np.float64) - end)
    assert np.abs(np.angle(np.exp(1j * (azimuth(cloud) - turned)))).max() < 1e-3, "clockwise from straight ahead"


def test_a_moving_sensor_bends_its_cloud_as_the_times_say(wall_at: Wall, scene_of: SceneOf) -> None:
    moments = EXACT.column_time_s()
    xyz = np.stack([1.5 * moments, 0 * moments, np.full_like(moments, HEIGHT_M)], axis=-1)
    poses = transform_from_xyz_rpy(xyz, np.stack([0 * moments, 0 * moments, 0.8 * moments], axis=-1))
    cloud = measured(scene_of(wall_at(6.0)), poses)
    ahead = np.abs(azimuth(cloud)) < 0.5
    column = np.searchsorted(moments, cloud.time_s[ahead].astype(np.float64) + 1e-6) - 1
    world = apply_transform(poses[column], cloud.xyz[ahead][:, None, :].astype(np.float64))[:, 0]
    assert world[:, 0] == pytest.approx(np.full(len(world), 6.0), abs=2e-3)
    assert np.abs(cloud.xyz[ahead][:, 0] - 6.0).max() > 0.1, "the raw cloud is bent"


def test_rain_takes_far_points_and_adds_near_ones(ground: TriangleMesh, scene_of: SceneOf, standing: Standing) -> None:
    scene, poses = scene_of(ground), standing(HEIGHT_M, EXACT.columns)
    clouds = [measured(scene, poses, weather=WeatherConfig(rain_mmph=rate)) for rate in (0.0, 10.0, 80.0)]
    drops = [int((cloud.surface == AIR).sum()) for cloud in clouds]
    strength = [float(cloud.intensity[cloud.ring == 3].mean()) for cloud in clouds]
    assert drops[0] == 0 < drops[1] < drops[2] < 0.2 * 16 * EXACT.columns
    assert strength[0] > strength[1] > strength[2]
    assert ranges(clouds[2])[clouds[2].surface == AIR].max() < 15


def test_dust_hides_what_is_behind_it(ground: TriangleMesh, scene_of: SceneOf, standing: Standing) -> None:
    scene, poses = scene_of(ground), standing(HEIGHT_M, EXACT.columns)
    clouds = [measured(scene, poses, weather=WeatherConfig(dust_per_m=dust)) for dust in (0.0, 0.05, 0.3)]
    solid = [int((cloud.surface != AIR).sum()) for cloud in clouds]
    assert solid[0] > solid[1] > solid[2]
    assert (clouds[2].surface == AIR).sum() > (clouds[1].surface == AIR).sum() > 100


def test_equal_generators_give_equal_clouds(ground: TriangleMesh, scene_of: SceneOf, standing: Standing) -> None:
    poses = standing(HEIGHT_M, EXACT.columns)
    weather = WeatherConfig(rain_mmph=10.0)
    one, two, other = (measured(scene_of(ground), poses, LidarConfig(), seed, weather) for seed in (3, 3, 4))
    assert all(a.tobytes() == b.tobytes() for a, b in zip(one, two, strict=True))
    assert one.xyz.tobytes() != other.xyz.tobytes()


@pytest.fixture(scope="module")
def clouds_of_places() -> Array:
    """Range, intensity and surface of dual-return clouds along the courses of MIM's scenarios."""
    config = LidarConfig(returns=Returns.dual)
    lidar, found = Lidar(config), []
    for name in ("mim_2", "mim_3"):
        world = make_world(load_scenario(config_folder() / "scenario" / f"{name}.yaml"), 1)
        scene = RayScene(world.mesh)
        for x, y in np.linspace(world.start_m, world.goal_m, 9)[[0, 2, 3, 5, 8]]:
            if world.obstacles.clearance(np.array([x]), np.array([y]))[0] < 0.6:
                continue
            poses = np.tile(np.eye(4), (config.columns, 1, 1))
            poses[:, :3, 3] = x, y, world.ground.height_at(np.array([x]), np.array([y]))[0] + 0.8
            cloud = lidar.measure(scene, poses, np.random.default_rng(0))
            assert np.isfinite(cloud.xyz).all()
            assert np.isfinite(cloud.intensity).all()
            found.append(np.stack([ranges(cloud), cloud.intensity, cloud.surface]))
    return np.concatenate(found, axis=1)


def mean_share(clouds: Array, name: str, near_m: float, far_m: float) -> float:
    distance, intensity, surface = clouds
    kept = (surface == surface_number(name)) & (distance > near_m) & (distance < far_m)
    assert kept.sum() > 100, name
    return float(intensity[kept].mean() / 255)


@pytest.mark.parametrize("name", ["plaster", "bark", "bush_leaf"])
def test_solid_obstacles_return_as_strongly_as_mim_says(name: str, clouds_of_places: Array) -> None:
    assert mean_share(clouds_of_places, name, 0.5, 10.0) > 0.75
    assert mean_share(clouds_of_places, name, 0.5, 5.0) > 0.75


@pytest.mark.parametrize("name", ["tall_grass", "bead", "glass"])
def test_grass_curtains_and_glass_return_as_weakly_as_mim_says(name: str, clouds_of_places: Array) -> None:
    assert mean_share(clouds_of_places, name, 0.5, 10.0) < 0.5


def test_wrong_settings_are_refused() -> None:
    for wrong in (
        {"firing_order": [0] * 16},
        {"elevation_rad": [0.1, 0.0]},
        {"min_range_m": 200.0},
        {"full_scale": 0.0},
        {"rate_hz": 50.0},
    ):
        with pytest.raises(SettingError, match=r"."):
            replace(LidarConfig(), **wrong)
