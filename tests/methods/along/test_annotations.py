"""Annotations: what a simulated place tells of itself, documents by hand, and their faults."""

import json
from pathlib import Path

import numpy as np
import pytest

from navtool.base.errors import DatasetsError
from navtool.methods.along.annotations import CLASSES, parse_annotations, read_annotations
from navtool.pipeline.intensity_map.config import GridConfig
from navtool.pipeline.intensity_map.obstacles import CellClass
from navtool.pipeline.intensity_map.truth import truth_classes
from navtool.sim.record.truth import obstacles_text
from navtool.sim.world.place import make_world
from navtool.sim.world.scenario import Partition, RoomConfig, Scatter, ScenarioConfig

SQUARE = [[0, 0], [1, 0], [1, 1.5], [0, 1]]


def one(**changed: object) -> dict[str, object]:
    return {"class": "solid", "outline_m": SQUARE, **changed}


def document(*obstacles: object, frame_id: object = "odom") -> str:
    return json.dumps({"frame_id": frame_id, "obstacles": list(obstacles)})


def test_what_is_written_is_read(tmp_path: Path) -> None:
    path = tmp_path / "place.json"
    path.write_text(document(one(), one(**{"class": "pliable", "kind": "reeds", "by": ["me"]})), encoding="utf-8")
    read = read_annotations(path)
    assert read.frame_id == "odom"
    assert [outline.what for outline in read.outlines] == [CellClass.solid, CellClass.pliable]
    assert (read.outlines[0].corners_m == np.array(SQUARE, float)).all()


def test_a_simulated_place_tells_the_same_of_itself() -> None:
    room = RoomConfig(length_m=8.0, width_m=6.0, partition=Partition.curtain)
    config = ScenarioConfig(name="told", side_m=20.0, course_m=5.0, room=room, pillars=Scatter(count=2))
    world = make_world(config, 0)
    read = parse_annotations(obstacles_text(world), "/ground_truth/obstacles")
    assert read.frame_id == "map"
    assert len(read.outlines) == len(world.obstacles.items)
    assert {outline.what for outline in read.outlines} == set(CLASSES.values())
    grid = GridConfig(cells=100, cell_m=0.1)
    classes = truth_classes(read.outlines, np.zeros(3), grid)
    middles = (np.arange(100) + 0.5 - 50) * 0.1
    x, y = np.meshgrid(middles, middles, indexing="ij")
    within = world.obstacles.clearance(x, y) < -0.01
    assert classes[within].all()
    assert not classes[world.obstacles.clearance(x, y) > 0.08].any()


def test_a_place_without_obstacles_is_free() -> None:
    assert parse_annotations(document(), "here").outlines == ()


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("{", "not JSON"),
        ("[" * 100_000, "not JSON"),
        ("[]", "not an object"),
        ("{}", "frame_id is missing"),
        (document(frame_id=7), "frame_id is 7"),
        ('{"frame_id": "odom"}', "obstacles is missing"),
        (document(5), r"obstacles\[0\] is 5"),
        (document(one(**{"class": "sold"})), "did you mean 'solid'"),
        (document(one(**{"class": "free"})), 'class is "free"'),
        (document(one(**{"class": ["solid"]})), "class is"),
        (document(one(outline_m=SQUARE[:2])), "wanted three corners"),
        (document(one(outline_m=[[0, 0], [1, 1], [2, 2]])), "has no area"),
        (document(one(outline_m=[*SQUARE, [1]])), r"outline_m\[4\] is \[1\]"),
        (document(one(outline_m=[*SQUARE, [1, True]])), r"outline_m\[4\]"),
        (document(one(outline_m=[*SQUARE, [1, float("nan")]])), r"outline_m\[4\]"),
        (document(one(outline_m=[*SQUARE, [1, 10**400]])), r"outline_m\[4\]"),
    ],
)
def test_a_fault_is_named_with_its_place_and_a_cure(text: str, told: str) -> None:
    with pytest.raises(DatasetsError, match=told) as caught:
        parse_annotations(text, "place.json")
    assert caught.value.where == "place.json"
    assert caught.value.cure


def test_all_faults_are_named_at_once_and_many_are_counted() -> None:
    with pytest.raises(DatasetsError) as caught:
        parse_annotations(document(one(**{"class": "x"}), 3, one(outline_m=1), frame_id=""), "p")
    for place in ("frame_id", "obstacles[0].class", "obstacles[1]", "obstacles[2].outline_m"):
        assert place in caught.value.what
    with pytest.raises(DatasetsError, match="and 30 faults more"):
        parse_annotations(document(*[None] * 50), "p")


def test_a_file_that_cannot_be_read_is_no_traceback(tmp_path: Path) -> None:
    with pytest.raises(DatasetsError, match="cannot be read"):
        read_annotations(tmp_path / "none.json")
    with pytest.raises(DatasetsError, match="cannot be read"):
        read_annotations(tmp_path)
    (tmp_path / "latin.json").write_bytes(b"\xff\xfe\xfa")
    with pytest.raises(DatasetsError, match="UTF-8"):
        read_annotations(tmp_path / "latin.json")
