"""The contact sheet: a picture of what happened, the same each time."""

from collections.abc import Callable

import cv2
import numpy as np
import pytest
from arc_drive import arc_drive

from navtool.pipeline.arrays import Array
from navtool.sim.drive.failure import Failure, FailureKind
from navtool.sim.record.config import SimulationConfig
from navtool.sim.record.drawing import PlaceMap, draw_cloud, surface_colours
from navtool.sim.record.episode import drive_episode, plan_episode, take_of
from navtool.sim.record.preview import MOMENTS, contact_sheet, contact_sheet_png, moments
from navtool.sim.record.stage import Stage
from navtool.sim.record.streams import Take
from navtool.sim.sensors.lidar import Cloud
from navtool.sim.world.surfaces import SURFACES

PURPLE, BLUE = (190, 0, 170), (30, 60, 220)


def share(picture: Array, colour: tuple[int, int, int]) -> float:
    return float((picture == colour).all(axis=-1).mean())


def test_a_sheet_shows_the_moments_and_is_the_same_each_time(
    take_of: Callable[..., Take], tiny: Callable[..., SimulationConfig]
) -> None:
    plan = plan_episode(tiny(), 0, 0)
    sheet = contact_sheet(take_of(), plan)
    assert sheet.shape[0] > MOMENTS * 240
    np.testing.assert_array_equal(sheet, contact_sheet(take_of(), plan))
    assert share(sheet, PURPLE) > share(contact_sheet(take_of(drive=arc_drive(2.0)), plan), PURPLE) == 0


@pytest.mark.parametrize("count", [0, 1, 2, 9])
def test_moments_are_in_order_and_see_failures_begin(count: int) -> None:
    kinds = list(FailureKind)
    failures = tuple(
        Failure(kinds[i % len(kinds)], 4.0 + 5 * i, 5.0 + 5 * i, 0.0, 0.0, "because") for i in range(count)
    )
    found = moments(arc_drive(60.0, failures=failures))
    assert len(found) == MOMENTS
    assert found == sorted(set(found))
    assert 0 < found[0] <= found[-1] < 60
    if count:
        assert any(abs(time_s - 3.7) < 1e-9 for time_s in found)


def test_the_map_puts_things_where_they_are(stage: Stage) -> None:
    drive = arc_drive(2.0)
    place = PlaceMap(stage.world, drive, 400)
    pixels = place.pixels(np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]))
    assert pixels[1, 0] > pixels[0, 0]
    assert pixels[1, 1] == pixels[0, 1]
    assert pixels[2, 1] < pixels[0, 1], "y is up"
    assert pixels[1, 0] - pixels[0, 0] == pytest.approx(pixels[0, 1] - pixels[2, 1], abs=1)
    before = place.canvas.copy()
    place.draw_drive(drive, [1.0])
    changed = np.argwhere((before != place.canvas).any(axis=-1))[:, ::-1]
    way = place.pixels(drive.position_m[:, :2])
    away = np.hypot(*(changed[:, None] - way[None]).transpose(2, 0, 1)).min(axis=1)
    assert away.max() < 12, "only along the way"


def test_a_cloud_from_above_has_ahead_up_and_left_left() -> None:
    xyz = np.array([[8.0, 0.0, 0.0], [0.0, 8.0, 0.0], [30.0, 0.0, 0.0]], np.float32)
    cloud = Cloud(
        xyz, np.array([255, 1, 9], np.float32), np.zeros(3, np.uint16), np.zeros(3, np.float32), np.zeros(3, np.uint8)
    )
    picture = draw_cloud(cloud, 200)
    ahead, left = picture[20, 100].astype(int), picture[100, 20].astype(int)
    assert ahead[0] > ahead[2], "255 is red"
    assert left[2] > left[0], "0 is blue"


def test_every_surface_has_a_colour_of_its_own() -> None:
    colours = surface_colours()
    kinds = {tuple(colour) for colour in [*colours[: len(SURFACES)].tolist(), colours[255].tolist()]}
    assert len(kinds) == len(SURFACES) + 1


def test_the_png_is_the_sheet_of_the_drive(tiny: Callable[..., SimulationConfig]) -> None:
    config = tiny()
    plan = plan_episode(config, 3, 1)
    stage, drive = drive_episode(config, plan)
    sheet = contact_sheet(take_of(config, plan, stage, drive), plan)
    png = np.frombuffer(contact_sheet_png(config, 3, 1), np.uint8)
    found = cv2.imdecode(png, cv2.IMREAD_COLOR)
    assert found is not None
    np.testing.assert_array_equal(found[..., ::-1], sheet, "red is red in the file too")
