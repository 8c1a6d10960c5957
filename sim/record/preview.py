"""A contact sheet of one episode: what the sensors saw at some moments, and the drive on the map."""

import cv2
import numpy as np
from jaxtyping import UInt8

from navtool.pipeline.arrays import Array
from navtool.sim.drive.drive import Drive
from navtool.sim.record.config import SimulationConfig
from navtool.sim.record.drawing import PlaceMap, draw_cloud, legend, surface_colours, write
from navtool.sim.record.episode import Plan, drive_episode, plan_episode, take_of
from navtool.sim.record.rig import CAMERA, LIDAR
from navtool.sim.record.streams import Take
from navtool.sim.sensors.camera import Camera
from navtool.sim.sensors.lidar import Lidar

MOMENTS = 4
_PICTURE_PX = 320, 240
_GAP, _HEAD, _MAP_PX, _LISTED = 8, 34, 900, 12
_BEFORE_S = 0.3
"""A failure is looked at so long before it begins: then its reason is still in the picture."""


def contact_sheet_png(config: SimulationConfig, seed: int, number: int) -> bytes:
    """A PNG of an episode: pictures, surfaces, clouds from above by intensity, and the map with path and failures.

    Raises:
        SimError: The episode cannot be driven.
    """
    plan = plan_episode(config, seed, number)
    stage, drive = drive_episode(config, plan)
    sheet = contact_sheet(take_of(config, plan, stage, drive), plan)
    return cv2.imencode(".png", np.ascontiguousarray(sheet[..., ::-1]))[1].tobytes()


def contact_sheet(take: Take, plan: Plan) -> UInt8[Array, "h w 3"]:
    """The same for an episode that has been driven."""
    drive, times = take.drive, moments(take.drive)
    rows, seen = [], set[int]()
    for number, time_s in enumerate(times, 1):
        picture, surfaces, cloud, shown = _look(take, time_s, number)
        seen |= shown
        label = np.full((22, 2 * _PICTURE_PX[0] + _PICTURE_PX[1] + 2 * _GAP, 3), 255, np.uint8)
        write(label, f"{number}  {time_s:.1f} s{_what_happens(drive, time_s)}", 2, 15)
        rows += [label, _beside(picture, surfaces, cloud), np.full((_GAP, label.shape[1], 3), 255, np.uint8)]
    left = np.concatenate([*rows, legend(seen, rows[0].shape[1])])
    place = PlaceMap(take.stage.world, drive, _MAP_PX)
    place.draw_drive(drive, times)
    right = np.concatenate([place.canvas, _table(drive)])
    height = max(len(left), len(right))
    body = _beside(
        *(np.pad(part, ((0, height - len(part)), (0, 0), (0, 0)), constant_values=255) for part in (left, right))
    )
    head = np.full((_HEAD, body.shape[1], 3), 255, np.uint8)
    world = take.stage.world
    title = f"{plan.path}   {world.config.light.illuminance_lux:,.0f} lux, rain {world.config.weather.rain_mmph:g} mm/h"
    write(head, f"{title}, {drive.duration_s:.1f} s, {100 * drive.failed_share:.0f} % of it failed", 8, 23, 0.55)
    return np.pad(np.concatenate([head, body]), ((0, _GAP), (_GAP, _GAP), (0, 0)), constant_values=255)


def moments(drive: Drive) -> list[float]:
    """Moments worth a look, in order: shortly before failures of different kinds begin, the others far from these."""
    first = {failure.kind: max(failure.start_s - _BEFORE_S, 0.0) for failure in reversed(drive.failures)}
    chosen = sorted(first.values())[: MOMENTS - 1]
    candidates = np.linspace(0.1, 0.95, 18) * drive.duration_s
    while len(chosen) < MOMENTS:
        apart = [min((abs(time_s - other) for other in chosen), default=time_s) for time_s in candidates.tolist()]
        chosen.append(float(candidates[int(np.argmax(apart))]) if chosen else float(candidates[0]))
    return sorted(chosen)


def _look(take: Take, time_s: float, number: int) -> tuple[Array, Array, Array, set[int]]:
    """The picture, its surfaces in colours and the cloud at a moment, and which surfaces are in the picture."""
    rng = np.random.default_rng([take.seed, number])
    camera, sensor = Camera(take.camera.model(), take.camera.sensor, take.seed), take.rig.mount(CAMERA)
    world, scene, shader = take.stage.world, take.stage.scene, take.stage.shader
    lux = world.config.light.illuminance_lux
    picture = camera.picture(shader, lambda s: take.drive.pose(time_s + s) @ sensor, lux, rng)
    lidar = Lidar(take.lidar, world.config.weather)
    poses = take.drive.pose(time_s + take.lidar.column_time_s()) @ take.rig.mount(LIDAR)
    cloud = draw_cloud(lidar.measure(scene, poses, rng), _PICTURE_PX[1])
    colours = cv2.resize(surface_colours()[picture.surface], _PICTURE_PX, interpolation=cv2.INTER_NEAREST)
    shown = np.unique(picture.surface).tolist()
    return cv2.resize(picture.rgb, _PICTURE_PX, interpolation=cv2.INTER_AREA), np.asarray(colours), cloud, set(shown)


def _beside(*pictures: Array) -> Array:
    """Pictures of one height side by side with a gap."""
    gap = np.full((len(pictures[0]), _GAP, 3), 255, np.uint8)
    return np.concatenate([part for picture in pictures for part in (picture, gap)][:-1], axis=1)


def _what_happens(drive: Drive, time_s: float) -> str:
    until = time_s + 2 * _BEFORE_S
    found = [f.kind.value for f in drive.failures if f.start_s <= until and f.end_s >= time_s]
    return f"   {', '.join(dict.fromkeys(found))}" if found else ""


def _table(drive: Drive) -> Array:
    """The failures in words."""
    lines = [
        f"{failure.start_s:6.1f} - {failure.end_s:.1f} s  {failure.kind.value}: {failure.reason}"
        for failure in drive.failures[:_LISTED]
    ] or ["nothing went wrong"]
    if len(drive.failures) > _LISTED:
        lines.append(f"and {len(drive.failures) - _LISTED} more")
    canvas = np.full((20 * len(lines) + 10, _MAP_PX, 3), 255, np.uint8)
    for row, line in enumerate(lines):
        write(canvas, line, 6, 20 * row + 20)
    return canvas
