"""Maps read back from the MCAP by rosbags, cell by cell, by the conventions of each message."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mapped_factory import STAMP_NS, map_config, mapped_anything, mapped_points
from mcap.reader import make_reader
from rosbags.highlevel import AnyReader

from navtool.methods.along.mcap_file import McapFile
from navtool.methods.along.writers import Outcome
from navtool.methods.intensity_map.mapped import LAYER_NAMES, MappedSweep
from navtool.methods.intensity_map.messages import CLASS_OCCUPANCY, MAP_FRAME, TOPICS, MapMessages
from navtool.pipeline.intensity_map.obstacles import CellClass


def written(path: Path, maps: list[MappedSweep], png: bytes | None = None) -> dict[str, list[Any]]:
    """The messages of a file by topic, read by rosbags from the definitions in the file alone."""
    with McapFile(path, MapMessages(lambda _: png)) as file:
        for mapped in maps:
            file.add(Outcome(mapped.number, mapped.sweep.stamp_ns, 0.0, mapped))
    found: dict[str, list[Any]] = {}
    with AnyReader([path]) as reader:
        for connection, stamp_ns, raw in reader.messages():
            message = reader.deserialize(raw, connection.msgtype)
            assert connection.msgtype == TOPICS[connection.topic]
            found.setdefault(connection.topic, []).append((stamp_ns, message))
    return found


def places(mapped: MappedSweep) -> list[tuple[int, int, float, float]]:
    """Row, column and middle of every cell, in metres in the frame of the map."""
    n, g = mapped.config.grid.cells, mapped.config.grid.cell_m
    return [(r, c, (r + 0.5 - n / 2) * g, (c + 0.5 - n / 2) * g) for r in range(n) for c in range(n)]


def test_an_occupancy_grid_has_each_cell_where_its_consumers_look(tmp_path: Path) -> None:
    mapped = mapped_anything()
    found = written(tmp_path / "maps.mcap", [mapped])
    occupancy = np.array([CLASS_OCCUPANCY[cell] for cell in sorted(CellClass)])
    for topic, expected in (
        ("/intensity_map/classes", occupancy[mapped.classes]),
        ("/intensity_map/plan", 100 * np.minimum(mapped.map.plan, 1)),
    ):
        ((_, grid),) = found[topic]
        assert grid.header.frame_id == MAP_FRAME
        origin, info = grid.info.origin.position, grid.info
        assert len(grid.data) == info.width * info.height
        for r, c, x, y in places(mapped):
            column = int((x - origin.x) / info.resolution)
            row = int((y - origin.y) / info.resolution)
            assert abs(int(grid.data[row * info.width + column]) - expected[r, c]) <= 0.501
        assert set(np.unique(grid.data)) <= set(range(101))


def test_a_grid_map_has_each_cell_where_its_library_looks(tmp_path: Path) -> None:
    mapped = mapped_anything()
    ((_, message),) = written(tmp_path / "maps.mcap", [mapped])["/intensity_map/layers"]
    assert message.layers == [*LAYER_NAMES, "classes", "plan"]
    assert (message.outer_start_index, message.inner_start_index) == (0, 0)
    info = message.info
    truth = {name: mapped.values[layer] for layer, name in enumerate(LAYER_NAMES)}
    truth |= {"classes": mapped.classes.astype(np.float32), "plan": mapped.map.plan}
    for name, data in zip(message.layers, message.data, strict=True):
        outer, inner = data.layout.dim
        assert (outer.label, inner.label) == ("column_index", "row_index")
        assert (outer.stride, inner.stride) == (outer.size * inner.size, inner.size)
        for r, c, x, y in places(mapped):
            # index (0, 0) is at the corner of +x and +y
            row = int((info.pose.position.x + info.length_x / 2 - x) / info.resolution)
            column = int((info.pose.position.y + info.length_y / 2 - y) / info.resolution)
            value = data.data[data.layout.data_offset + column * inner.stride + row]
            if name in LAYER_NAMES and not mapped.map.layers.points[LAYER_NAMES.index(name), r, c]:
                assert np.isnan(value)
            else:
                assert value == truth[name][r, c]


def test_a_wall_to_the_left_is_to_the_left_in_every_message(tmp_path: Path) -> None:
    y = np.full(400, 3.2, np.float32)
    xyz = np.stack([np.linspace(-1, 1, 400, dtype=np.float32), y, np.zeros(400, np.float32)], axis=1)
    mapped = mapped_points(xyz, np.full(400, 250, np.float32))
    ((_, grid),) = written(tmp_path / "maps.mcap", [mapped])["/intensity_map/classes"]
    rows, columns = np.nonzero(np.reshape(grid.data, (grid.info.height, grid.info.width)))
    left = rows * grid.info.resolution + grid.info.origin.position.y
    assert left.min() > 2.5
    assert abs(columns * grid.info.resolution + grid.info.origin.position.x).max() < 1.6


def test_the_transform_places_the_map_in_the_odometry(tmp_path: Path) -> None:
    found = written(tmp_path / "maps.mcap", [mapped_anything(0), mapped_anything(1, place=None)])
    ((stamp_ns, message),) = found["/tf"]
    (transform,) = message.transforms
    assert (transform.header.frame_id, transform.child_frame_id) == ("odom", MAP_FRAME)
    at, turn = transform.transform.translation, transform.transform.rotation
    assert (at.x, at.y) == (1.0, -2.0)
    assert 2 * np.arctan2(turn.z, turn.w) == pytest.approx(0.5)
    assert stamp_ns == STAMP_NS == transform.header.stamp.sec * 10**9 + transform.header.stamp.nanosec


def test_pictures_and_order(tmp_path: Path) -> None:
    maps = [mapped_anything(number) for number in range(3)]
    found = written(tmp_path / "maps.mcap", maps, b"not really a PNG")
    assert [bytes(message.data) for _, message in found["/intensity_map/picture"]] == [b"not really a PNG"] * 3
    assert {topic: len(messages) for topic, messages in found.items()} == dict.fromkeys(TOPICS, 3)
    for messages in found.values():
        assert [stamp_ns for stamp_ns, _ in messages] == [mapped.sweep.stamp_ns for mapped in maps]


def test_the_file_says_what_it_is_and_is_the_same_each_time(tmp_path: Path) -> None:
    for name in ("one.mcap", "two.mcap"):
        written(tmp_path / name, [mapped_anything(3, config=map_config(cells=16))])
    assert (tmp_path / "one.mcap").read_bytes() == (tmp_path / "two.mcap").read_bytes()
    with (tmp_path / "one.mcap").open("rb") as file:
        reader = make_reader(file)
        assert reader.get_header().profile == "ros2"
        summary = reader.get_summary()
    assert summary is not None
    assert summary.statistics is not None
    assert summary.statistics.message_count == 4
    assert {schema.encoding for schema in summary.schemas.values()} == {"ros2msg"}
