"""Whether the simulated sensors show what the papers and data sheets say sensors show."""

from collections.abc import Iterable, Iterator
from functools import partial
from typing import NamedTuple

import numpy as np
from _sim_places import MODEL, camera_poses, lidar_poses, scenario, stands
from numpy.typing import NDArray

from navtool.pipeline.image_reliability import ImageReliability, ImageReliabilityConfig, image_reliability
from navtool.sim.sensors.camera import Camera
from navtool.sim.sensors.camera_config import CameraConfig
from navtool.sim.sensors.exposure import Exposure
from navtool.sim.sensors.lidar import AIR, Cloud, Lidar
from navtool.sim.sensors.lidar_config import LidarConfig, Returns
from navtool.sim.sensors.shader import Shader
from navtool.sim.world.mesh import TriangleMesh, join_meshes, make_mesh
from navtool.sim.world.place import make_world
from navtool.sim.world.ray_scene import RayScene
from navtool.sim.world.scenario import WeatherConfig
from navtool.sim.world.surfaces import surface_number

type Column = NDArray[np.float64]

CLAIMED, SEEDS = ("mim_1", "mim_2", "mim_3", "mim_4", "demo"), range(3)
SOLID = ("plaster", "brick", "bark", "rock", "bush_leaf")
WEAK = ("tall_grass", "bead", "glass")
PLANTS = ("bark", "bush_leaf", "leaf", "tall_grass")
NEAR_M, FAR_M = 0.5, 10.0
WALL_M, PANE_M = 4.0, 3.0
WEATHERS = (
    ("rain of 10 mm/h", WeatherConfig(rain_mmph=10.0)),
    ("rain of 50 mm/h", WeatherConfig(rain_mmph=50.0)),
    ("dust of 0.02 per m", WeatherConfig(dust_per_m=0.02)),
    ("dust of 0.2 per m", WeatherConfig(dust_per_m=0.2)),
)
DIM_LUX, YAW_RATES_RADPS = 200.0, (0.0, 0.5, 1.0, 1.5)
LIGHTS_LUX = (50_000.0, 1000.0, 100.0, 10.0, 1.0)
RESAMPLES = 400


class Claim(NamedTuple):
    """A measured figure beside what is said of it."""

    what: str
    measured: float
    unit: str
    interval: tuple[float, float] | None
    """95 %, resampling clouds or pictures."""
    number: int
    """Number of points, beams or pictures."""
    said: str
    """By whom, and what; empty where nobody gives a figure."""
    holds: bool | None = None
    """None where there is nothing to hold against."""


def claims() -> Iterator[Claim]:
    yield from intensity_claims()
    yield from geometry_claims()
    yield from weather_claims()
    yield from camera_claims()


def intensity_claims() -> Iterator[Claim]:
    """What MIM calls solid, pliable and transparent, as a share of the full scale R; and which beams return twice."""
    clouds = list(clouds_of_places())
    nearest = min(float(np.linalg.norm(cloud.xyz, axis=1).min()) for cloud in clouds)
    points = sum(len(cloud.xyz) for cloud in clouds)
    said = "MIM's blind zone: 0.5 m"
    yield Claim("nearest point of any cloud", nearest, "m", None, points, said, nearest >= NEAR_M - 1e-3)
    for name in SOLID + WEAK:
        solid = name in SOLID
        strengths = [within(cloud, name) for cloud in clouds]
        mean, interval, count = ratio(strengths, [np.ones_like(part) for part in strengths])
        said = "MIM: above 0.75 R" if solid else "MIM: below 0.5 R"
        yield Claim(f"{name}: mean intensity", mean, "R", interval, count, said, mean > 0.75 if solid else mean < 0.5)
        beyond = [(part > 0.75 if solid else part < 0.5).astype(np.float64) for part in strengths]
        share, interval, count = ratio(beyond, [np.ones_like(part) for part in beyond])
        yield Claim(f"{name}: share of points {said[5:]}", share, "", interval, count, "MIM: typically", share > 0.5)
    for name in PLANTS:
        pairs = [returned_twice(cloud, surface_number(name)) for cloud in clouds]
        share, interval, _ = ratio([twice for twice, _ in pairs], [beams for _, beams in pairs])
        count = int(sum(beams.sum() for _, beams in pairs))
        yield Claim(f"{name}: share of its beams that return twice", share, "", interval, count, "")


def geometry_claims() -> Iterator[Claim]:
    """Range of a wall, and what a pane in front of a wall returns."""
    config = LidarConfig(returns=Returns.dual)
    wall = cloud_of(RayScene(sheet(WALL_M, "concrete")), config)
    reach = np.linalg.norm(wall.xyz.astype(np.float64), axis=1)
    error = (reach - WALL_M * reach / wall.xyz[:, 0])[np.abs(wall.xyz[:, 1]) < WALL_M]
    said = f"set: {100 * config.range_noise_m:g} cm"
    yield Claim(f"range error on a wall at {WALL_M:g} m, mean", 100 * float(error.mean()), "cm", None, error.size, "")
    deviation = 100 * float(error.std())
    what = f"range error on a wall at {WALL_M:g} m, standard deviation"
    yield Claim(what, deviation, "cm", None, error.size, said, abs(deviation / 100 / config.range_noise_m - 1) < 0.05)
    pane = cloud_of(RayScene(join_meshes([sheet(PANE_M, "glass"), sheet(7.0, "concrete")])), config)
    glass = pane.surface == surface_number("glass")
    reach = np.linalg.norm(pane.xyz, axis=1)
    angle = float(np.degrees(np.arccos(np.minimum(PANE_M / reach[glass], 1))).max())
    said = "MIM: returns only near its normal"
    count = int(glass.sum())
    yield Claim("glass: largest angle from the normal that returns", angle, "degrees", None, count, said, angle < 20)
    strongest = float(pane.intensity[glass].max() / 255)
    yield Claim(
        "glass: strongest point", strongest, "R", None, count, "MIM: low intensity, below 0.5 R", strongest < 0.5
    )


def weather_claims() -> Iterator[Claim]:
    """What rain and dust take from a cloud and add to it."""
    world = make_world(scenario("graspe_1"), 0)
    scene, places = RayScene(world.mesh), stands(world)
    config = LidarConfig()

    def clouds(weather: WeatherConfig | None) -> list[Cloud]:
        lidar = Lidar(config, weather)
        return [
            lidar.measure(scene, lidar_poses(stand, config.columns), np.random.default_rng(number))
            for number, stand in enumerate(places)
        ]

    dry = [np.array([float(len(cloud.xyz))]) for cloud in clouds(None)]
    for name, weather in WEATHERS:
        found = clouds(weather)
        lost = [before - (cloud.surface != AIR).sum() for before, cloud in zip(dry, found, strict=True)]
        share, interval, _ = ratio(lost, dry)
        count = int(sum(before.sum() for before in dry))
        yield Claim(f"{name}: share of points lost", share, "", interval, count, "")
        false = [np.array([float((cloud.surface == AIR).sum())]) for cloud in found]
        total = [np.array([float(len(cloud.xyz))]) for cloud in found]
        share, interval, _ = ratio(false, total)
        yield Claim(f"{name}: share of points in the air", share, "", interval, int(sum(n.sum() for n in total)), "")


def camera_claims() -> Iterator[Claim]:
    """Navtool's own image reliability against yaw rate and light; what the exposure does."""
    config = CameraConfig()
    shaders = []
    for name in ("demo", "graspe_1"):
        world = make_world(scenario(name), 0)
        shaders += [(Shader(world, RayScene(world.mesh)), stand) for stand in stands(world)]
    camera = Camera(MODEL, config)

    def look(lux: float, yaw_rate_radps: float) -> tuple[list[ImageReliability], list[Exposure]]:
        taken = [
            camera.picture(shader, partial(camera_poses, stand, turn_radps=yaw_rate_radps), lux, rng)
            for number, (shader, stand) in enumerate(shaders)
            for rng in [np.random.default_rng(number)]
        ]
        return [image_reliability(one.rgb, ImageReliabilityConfig()) for one in taken], [one.exposure for one in taken]

    before = np.inf
    for rate in YAW_RATES_RADPS:
        corners, interval = mean([found.corners for found in look(DIM_LUX, rate)[0]])
        what = f"r_corners at {DIM_LUX:g} lux while turning at {rate:g} rad/s"
        said = "GrASPE, Fig. 4: motion blur takes corners"
        yield Claim(what, corners, "", interval, len(shaders), said, None if np.isinf(before) else corners < before)
        before = corners
    earlier = np.inf
    for lux in LIGHTS_LUX:
        found, exposures = look(lux, 0.0)
        image, interval = mean([one.image for one in found])
        said = "GrASPE, Fig. 4: falls with the light"
        holds = None if np.isinf(earlier) else image <= earlier + 0.02
        yield Claim(f"image reliability at {lux:g} lux", image, "", interval, len(found), said, holds)
        earlier = image
        bright, interval = mean([one.brightness for one in found])
        yield Claim(f"r_bright at {lux:g} lux", bright, "", interval, len(found), "")
        shutter, interval = mean([1000 * one.shutter_s for one in exposures])
        limit = 1000 * config.longest_shutter_s
        said = f"set: at most {limit:.3g} ms"
        yield Claim(f"exposure at {lux:g} lux", shutter, "ms", interval, len(found), said, shutter <= limit + 1e-6)
        gain, interval = mean([one.gain for one in exposures])
        said = f"set: at most {config.largest_gain:g}"
        yield Claim(f"gain at {lux:g} lux", gain, "", interval, len(found), said, gain <= config.largest_gain + 1e-6)


def clouds_of_places() -> Iterator[Cloud]:
    lidar = Lidar(LidarConfig(returns=Returns.dual))
    for name in CLAIMED:
        for seed in SEEDS:
            world = make_world(scenario(name), seed)
            scene = RayScene(world.mesh)
            for number, stand in enumerate(stands(world)):
                rng = np.random.default_rng([seed, number])
                yield lidar.measure(scene, lidar_poses(stand, lidar.config.columns), rng)


def within(cloud: Cloud, surface: str) -> Column:
    """Intensities of the points of a surface within the ranges that count, as shares of the full scale."""
    reach = np.linalg.norm(cloud.xyz, axis=1)
    kept = (cloud.surface == surface_number(surface)) & (reach > NEAR_M) & (reach < FAR_M)
    return np.asarray(cloud.intensity[kept].astype(np.float64) / 255)


def returned_twice(cloud: Cloud, surface: int) -> tuple[Column, Column]:
    """How many of a surface's beams return twice, and how many there are: those whose first point is on it."""
    again = (np.diff(cloud.time_s) == 0) & (np.diff(cloud.ring.astype(int)) == 0)
    second, first = np.append(False, again), np.append(again, False)
    mine = ~second & (cloud.surface == surface) & (np.linalg.norm(cloud.xyz, axis=1) < FAR_M)
    return np.array([float((mine & first).sum())]), np.array([float(mine.sum())])


def ratio(parts: Iterable[Column], wholes: Iterable[Column]) -> tuple[float, tuple[float, float], int]:
    """The sum of all parts over that of all wholes, its interval, and how many numbers went in."""
    numbers = list(parts)
    part = np.array([values.sum() for values in numbers])
    whole = np.array([values.sum() for values in wholes])
    draws = np.random.default_rng(0).integers(0, len(part), (RESAMPLES, len(part)))
    found = part[draws].sum(axis=1) / np.maximum(whole[draws].sum(axis=1), 1)
    low, high = np.quantile(found, [0.025, 0.975]).tolist()
    return float(part.sum() / max(whole.sum(), 1)), (low, high), sum(values.size for values in numbers)


def mean(values: list[float]) -> tuple[float, tuple[float, float]]:
    found, interval, _ = ratio([np.array([value]) for value in values], [np.ones(1) for _ in values])
    return found, interval


def sheet(x: float, surface: str) -> TriangleMesh:
    corners = np.array([[x, -60, -9], [x, 60, -9], [x, 60, 9], [x, -60, 9]])
    return make_mesh(corners, np.array([[0, 1, 2], [0, 2, 3]]), surface_number(surface))


def cloud_of(scene: RayScene, config: LidarConfig) -> Cloud:
    return Lidar(config).measure(scene, np.tile(np.eye(4), (config.columns, 1, 1)), np.random.default_rng(0))
