"""The simulated world and its sensors: what a frame costs, and whether they show what the papers say sensors show.

``python benchmarks/sim.py --docs`` also writes the figures into docs/simulation.md.
"""

import resource
import sys
import time
from collections.abc import Callable, Iterator
from functools import partial

import cv2
import numpy as np
from _report import Row, machine, write_report
from _sim_claims import Claim, claims
from _sim_places import MODEL, ROOT, camera_poses, lidar_poses, scenario, stands
from numpy.typing import NDArray

from navtool.sim.sensors.camera import Camera
from navtool.sim.sensors.lidar import Lidar
from navtool.sim.sensors.shader import Shader
from navtool.sim.world.place import make_world
from navtool.sim.world.ray_scene import RayScene

PAGE = ROOT / "docs" / "simulation.md"
BEGIN, END = "<!-- figures: python benchmarks/sim.py --docs -->", "<!-- end of figures -->"
TIMED, ROUNDS = ("demo", "graspe_1", "mim_4"), 5
FRAMES_BAR, MEMORY_BAR_MIB = 12.0, 1536.0


def main() -> None:
    cv2.setNumThreads(1)
    rows = [row for name in TIMED for row in speed_rows(name)]
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    rows.append(Row(what="peak memory", ours=peak, unit="MiB", bar=MEMORY_BAR_MIB, holds=peak <= MEMORY_BAR_MIB))
    found = list(claims())
    told = [Row(what=one.what, ours=one.measured, unit=one.unit, holds=one.holds is not False) for one in found]
    write_report("sim", rows + told)
    if "--docs" in sys.argv[1:]:
        write_page(rows, found)


def speed_rows(name: str) -> Iterator[Row]:
    """One core's time for a sweep and a picture, beside what Embree alone takes for a ray a beam and a ray a pixel."""
    start = time.process_time()
    world = make_world(scenario(name), 0)
    scene = RayScene(world.mesh)
    built = time.process_time() - start
    shader = Shader(world, scene)
    lit = time.process_time() - start - built
    lidar, rng = Lidar(), np.random.default_rng(0)
    camera, large = Camera(MODEL), Camera(MODEL.scaled_to(640, 480))
    times: list[list[float]] = [[], [], [], [], []]
    for stand in stands(world):
        sweep, pose_at = lidar_poses(stand, lidar.config.columns), partial(camera_poses, stand)
        beams, pixels = seen_from(sweep[0], beam_rays(lidar)), seen_from(pose_at(np.zeros(1))[0], pixel_rays())
        actions: tuple[Callable[[], object], ...] = (
            partial(lidar.measure, scene, sweep, rng),
            partial(scene.cast, *beams),
            partial(camera.picture, shader, pose_at, 5e4, rng),
            partial(scene.cast, *pixels),
            partial(large.picture, shader, pose_at, 5e4, rng),
        )
        for action, taken in zip(actions, times, strict=True):
            taken.append(1000 * min(cpu_seconds(action) for _ in range(ROUNDS)))
    cloud, beam, picture, pixel, four = (float(np.mean(taken)) for taken in times)
    triangles = len(world.mesh.triangles)
    yield Row(what=f"{name}: building it, {triangles} triangles, a ray tree included", ours=built, unit="s")
    yield Row(what=f"{name}: casting its light", ours=lit, unit="s")
    yield Row(what=f"{name}: a VLP-16 sweep", ours=cloud, peer=beam, ratio=beam / cloud, unit="ms")
    yield Row(what=f"{name}: a picture of 320x240", ours=picture, peer=pixel, ratio=pixel / picture, unit="ms")
    yield Row(what=f"{name}: a picture of 640x480", ours=four, unit="ms")
    rate = 1000 / (cloud + picture)
    what = f"{name}: frames of 320x240 picture and sweep a second and core"
    yield Row(what=what, ours=rate, unit="Hz", bar=FRAMES_BAR, holds=rate >= FRAMES_BAR)


def beam_rays(lidar: Lidar) -> NDArray[np.float64]:
    elevation, azimuth = np.broadcast_arrays(np.array(lidar.config.elevation_rad)[:, None], lidar.config.azimuth_rad())
    flat = np.cos(elevation)
    rays = np.stack([flat * np.cos(azimuth), flat * np.sin(azimuth), np.sin(elevation)], axis=-1)
    return rays.reshape(-1, 3)


def pixel_rays() -> NDArray[np.float64]:
    u, v = np.meshgrid(np.arange(MODEL.width), np.arange(MODEL.height))
    return MODEL.rays(np.column_stack([u.ravel(), v.ravel()]).astype(np.float64)).directions


def seen_from(pose: NDArray[np.float64], rays: NDArray[np.float64]) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Origins and directions of a sensor's rays in the world."""
    origins = np.tile(pose[:3, 3].astype(np.float32), (len(rays), 1))
    return origins, np.ascontiguousarray(rays @ pose[:3, :3].T, np.float32)


def cpu_seconds(action: Callable[[], object]) -> float:
    """The time that the core worked, so that waiting for a busy machine does not count."""
    start = time.process_time()
    action()
    return time.process_time() - start


def write_page(rows: list[Row], found: list[Claim]) -> None:
    """Write the figures between the two marks of the page."""
    page = PAGE.read_text(encoding="utf-8")
    head, rest = page.split(BEGIN)
    tail = rest.split(END)[1]
    lines = [
        BEGIN,
        "",
        f"Speed on one core of {machine()['processor']}, its own time; Embree alone: a ray a beam, or a pixel.",
        "",
        "| what | measured | Embree alone | bar | holds |",
        "|---|---|---|---|---|",
    ]
    for row in rows:
        peer = "" if row.peer is None else f"{row.peer:.3g} {row.unit}"
        bar, holds = ("", "") if row.bar is None else (f"{row.bar:g} {row.unit}", "yes" if row.holds else "no")
        lines.append(f"| {row.what} | {row.ours:.3g} {row.unit} | {peer} | {bar} | {holds} |")
    lines += [
        "",
        "Claims; intervals of 95 % by drawing clouds or pictures again.",
        "",
        "| what | measured | interval | n | who says what | holds |",
        "|---|---|---|---|---|---|",
    ]
    for one in found:
        interval = "" if one.interval is None else f"{one.interval[0]:.3g} to {one.interval[1]:.3g}"
        holds = "" if one.holds is None else "yes" if one.holds else "no"
        measured = f"{one.measured:.3g} {one.unit}".strip()
        lines.append(f"| {one.what} | {measured} | {interval} | {one.number} | {one.said} | {holds} |")
    PAGE.write_text(head + "\n".join([*lines, "", END]) + tail, encoding="utf-8")


if __name__ == "__main__":
    main()
