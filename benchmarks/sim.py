"""The simulated world and its sensors: what a frame costs, and whether they show what the papers say sensors show.

``python benchmarks/sim.py --docs`` also writes the figures into docs/simulation.md.
"""

import resource
import sys
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np
from _report import Row, machine, write_report
from numpy.typing import NDArray

from navtool.pipeline.geometry.camera import CameraModel
from navtool.pipeline.geometry.transforms import transform_from_xyz_rpy
from navtool.sim.sensors.camera import Camera
from navtool.sim.sensors.lidar import Lidar
from navtool.sim.sensors.lidar_config import LidarConfig, Returns
from navtool.sim.sensors.shader import Shader
from navtool.sim.world.place import World, make_world
from navtool.sim.world.ray_scene import RayScene
from navtool.sim.world.scenario import load_scenario
from navtool.sim.world.surfaces import surface_number

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "simulation.md"
BEGIN, END = "<!-- figures: python benchmarks/sim.py --docs -->", "<!-- end of figures -->"
TIMED = ("demo", "graspe_1", "mim_4")
CLAIMED = ("mim_2", "mim_3", "demo", "graspe_1")
PLACES, ROUNDS = 6, 4
SWEEP_BAR_MS, PICTURE_BAR_MS, FRAMES_BAR, MEMORY_BAR_MIB = 40.0, 40.0, 12.0, 1536.0
OPTICAL = np.array([[0.0, 0, 1, 0], [-1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 0, 1]])
MODEL = CameraModel(320, 240, 228.5, 228.5, 159.5, 119.5, "plumb_bob", (-0.28, 0.07, 0.0005, -0.0003, 0.0))


class Stand(NamedTuple):
    """Where the sensors are in a place that they have room in."""

    x_m: float
    y_m: float
    ground_m: float


def main() -> None:
    cv2.setNumThreads(1)
    rows = [row for name in TIMED for row in speed_rows(name)]
    rows += claim_rows()
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    rows.append(Row(what="peak memory", ours=peak, unit="MiB", bar=MEMORY_BAR_MIB, holds=peak <= MEMORY_BAR_MIB))
    write_report("sim", rows)
    if "--docs" in sys.argv[1:]:
        write_page(rows)


def speed_rows(name: str) -> Iterator[Row]:
    """One core's time for a sweep and a picture, against Embree alone with a ray a beam and a ray a pixel."""
    start = time.process_time()
    world = make_world(load_scenario(ROOT / "configs" / "scenario" / f"{name}.yaml"), 0)
    scene = RayScene(world.mesh)
    built = time.process_time() - start
    shader = Shader(world, scene)
    lit = time.process_time() - start - built
    lidar, camera, rng = Lidar(), Camera(MODEL), np.random.default_rng(0)
    times: list[list[float]] = [[], [], [], []]
    for stand in stands(world):
        sweep = lidar_poses(stand, lidar.config.columns)
        beams, pixels = beam_rays(lidar), pixel_rays()
        actions: tuple[Callable[[], object], ...] = (
            partial(lidar.scan, scene, sweep, rng),
            partial(scene.cast, origins(stand, 0.8, len(beams)), beams),
            partial(camera.picture, shader, partial(camera_poses, stand), 5e4, rng),
            partial(scene.cast, origins(stand, 0.6, len(pixels)), pixels),
        )
        for action, taken in zip(actions, times, strict=True):
            taken.append(1000 * min(cpu_seconds(action) for _ in range(ROUNDS)))
    cloud, beam, picture, pixel = (float(np.mean(taken)) for taken in times)
    triangles = len(world.mesh.triangles)
    yield Row(what=f"{name}: building it, {triangles} triangles, a ray tree included", ours=built, unit="s")
    yield Row(what=f"{name}: casting its light", ours=lit, unit="s")
    yield timed(f"{name}: a VLP-16 sweep, against its 28,928 beams in Embree alone", cloud, beam, SWEEP_BAR_MS)
    yield timed(f"{name}: a picture of 320x240, against its 76,800 pixels in Embree", picture, pixel, PICTURE_BAR_MS)
    rate = 1000 / (cloud + picture)
    what = f"{name}: frames of picture and sweep a second and core"
    yield Row(what=what, ours=rate, unit="Hz", bar=FRAMES_BAR, holds=rate >= FRAMES_BAR)


def timed(what: str, ours: float, peer: float, bar: float) -> Row:
    return Row(what=what, ours=ours, peer=peer, ratio=peer / ours, unit="ms", bar=bar, holds=ours <= bar)


def claim_rows() -> Iterator[Row]:
    """Mean intensity of what MIM calls solid, pliable and transparent, as a share of the full scale R."""
    lidar = Lidar(LidarConfig(returns=Returns.dual))
    clouds = []
    for name in CLAIMED:
        for seed in range(3):
            world = make_world(load_scenario(ROOT / "configs" / "scenario" / f"{name}.yaml"), seed)
            scene = RayScene(world.mesh)
            for stand in stands(world):
                cloud = lidar.scan(scene, lidar_poses(stand, lidar.config.columns), np.random.default_rng(seed))
                clouds.append(np.stack([np.linalg.norm(cloud.xyz, axis=1), cloud.intensity, cloud.surface]))
    distance, intensity, surface = np.concatenate(clouds, axis=1)
    nearest = float(distance.min())
    yield Row(what="nearest point of any cloud", ours=nearest, unit="m", bar=0.5, holds=nearest >= 0.5 - 1e-3)
    kept = (distance > 0.5) & (distance < 10)
    for name, solid in (
        ("plaster", True),
        ("brick", True),
        ("bark", True),
        ("rock", True),
        ("bush_leaf", True),
        ("tall_grass", False),
        ("bead", False),
        ("glass", False),
    ):
        share = float(intensity[kept & (surface == surface_number(name))].mean() / 255)
        bar = 0.75 if solid else 0.5
        what = f"mean intensity within 10 m, {name} ({'solid: above' if solid else 'not solid: below'} the bar)"
        yield Row(what=what, ours=share, unit="R", bar=bar, holds=share > bar if solid else share < bar)


def stands(world: World) -> list[Stand]:
    """Places along the course where the robot would not touch anything that does not yield."""
    found = []
    for x, y in np.linspace(world.start_m, world.goal_m, PLACES).tolist():
        at = np.array([x]), np.array([y])
        if world.obstacles.only(pliable=False).clearance(*at)[0] > 0.5:
            found.append(Stand(x, y, float(world.ground.height_at(*at)[0])))
    return found


def lidar_poses(stand: Stand, columns: int) -> NDArray[np.float64]:
    poses = np.tile(np.eye(4), (columns, 1, 1))
    poses[:, :3, 3] = stand.x_m, stand.y_m, stand.ground_m + 0.8
    return poses


def camera_poses(stand: Stand, time_s: NDArray[np.float64]) -> NDArray[np.float64]:
    zero = np.zeros_like(time_s)
    xyz = np.stack([stand.x_m + 0.8 * time_s, zero + stand.y_m, zero + stand.ground_m + 0.6], axis=-1)
    return np.asarray(transform_from_xyz_rpy(xyz, np.stack([zero, zero + 0.08, 0.5 * time_s], axis=-1)) @ OPTICAL)


def beam_rays(lidar: Lidar) -> NDArray[np.float32]:
    elevation, azimuth = np.broadcast_arrays(np.array(lidar.config.elevation_rad)[:, None], lidar.config.azimuth_rad())
    flat = np.cos(elevation)
    rays = np.stack([flat * np.cos(azimuth), flat * np.sin(azimuth), np.sin(elevation)], axis=-1)
    return np.ascontiguousarray(rays.reshape(-1, 3), np.float32)


def pixel_rays() -> NDArray[np.float32]:
    u, v = np.meshgrid(np.arange(MODEL.width), np.arange(MODEL.height))
    optical = MODEL.rays(np.column_stack([u.ravel(), v.ravel()]).astype(np.float64)).directions
    turn = transform_from_xyz_rpy(np.zeros(3), np.array([0.0, 0.08, 0.0])) @ OPTICAL
    return np.ascontiguousarray(optical @ turn[:3, :3].T, np.float32)


def origins(stand: Stand, height_m: float, count: int) -> NDArray[np.float32]:
    return np.tile(np.array([[stand.x_m, stand.y_m, stand.ground_m + height_m]], np.float32), (count, 1))


def cpu_seconds(action: Callable[[], object]) -> float:
    """The time that the core worked, so that waiting for a busy machine does not count."""
    start = time.process_time()
    action()
    return time.process_time() - start


def write_page(rows: list[Row]) -> None:
    """Write the figures between the two marks of the page."""
    page = PAGE.read_text(encoding="utf-8")
    head, rest = page.split(BEGIN)
    tail = rest.split(END)[1]
    lines = [
        BEGIN,
        f"Measured on {machine()['processor']}, one core.",
        "",
        "| what | measured | bar | holds |",
        "|---|---|---|---|",
    ]
    for row in rows:
        bar, holds = ("", "") if row.bar is None else (f"{row.bar:g} {row.unit}", "yes" if row.holds else "no")
        against = "" if row.peer is None else f" (Embree alone {row.peer:.3g})"
        lines.append(f"| {row.what} | {row.ours:.3g} {row.unit}{against} | {bar} | {holds} |")
    PAGE.write_text(head + "\n".join([*lines, END]) + tail, encoding="utf-8")


if __name__ == "__main__":
    main()
