"""Point clouds of any layout against a loop that unpacks one number at a time."""

import math
import struct
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from navtool.base.errors import DatasetsError
from navtool.datasets.decode.messages import PointCloud
from navtool.datasets.decode.point_cloud import decode_point_cloud

CLOUD = "sensor_msgs/msg/PointCloud2"
CODES = {1: "b", 2: "B", 3: "h", 4: "H", 5: "i", 6: "I", 7: "f", 8: "d", 9: "q", 10: "Q"}
STAMP_NS = 1_700_000_000_250_000_000
type Make = Callable[..., Any]


class Field(NamedTuple):
    name: str
    datatype: int
    elements: int = 1
    gap: int = 0
    """Bytes of padding before it."""


class Layout(NamedTuple):
    fields: tuple[Field, ...]
    height: int
    width: int
    tail: int
    """Bytes of padding behind a point."""
    row_padding: int
    big_endian: bool
    seed: int


def offsets(layout: Layout) -> tuple[list[int], int]:
    """The offset of each field, and the size of a point."""
    found, end = [], 0
    for field in layout.fields:
        found.append(end + field.gap)
        end = found[-1] + struct.calcsize(f"={CODES[field.datatype]}") * field.elements
    return found, end + layout.tail


def cloud_fields(layout: Layout, values: Callable[[Field, int], list[float]]) -> dict[str, Any]:
    """The message's fields; ``values(field, index)`` gives the numbers of a point."""
    places, step = offsets(layout)
    row = layout.width * step + layout.row_padding
    data = bytearray(np.random.default_rng(layout.seed).bytes(row * layout.height))
    order = ">" if layout.big_endian else "<"
    for index in range(layout.height * layout.width):
        start = index // layout.width * row + index % layout.width * step
        for field, place in zip(layout.fields, places, strict=True):
            struct.pack_into(
                f"{order}{field.elements}{CODES[field.datatype]}", data, start + place, *values(field, index)
            )
    return {
        "header": {"stamp": {"sec": STAMP_NS // 10**9, "nanosec": STAMP_NS % 10**9}, "frame_id": "lidar"},
        "height": layout.height,
        "width": layout.width,
        "fields": [
            {"name": x.name, "offset": place, "datatype": x.datatype, "count": x.elements}
            for x, place in zip(layout.fields, places, strict=True)
        ],
        "is_bigendian": layout.big_endian,
        "point_step": step,
        "row_step": row,
        "data": np.frombuffer(bytes(data), np.uint8),
    }


datatypes = st.integers(1, 10)
gaps = st.integers(0, 5)


@st.composite
def layouts(draw: st.DrawFn) -> Layout:
    """Coordinates, perhaps intensity, ring and time, and other fields, in any order with any padding."""
    fields = [Field(name, draw(datatypes), 1, draw(gaps)) for name in "xyz"]
    if draw(st.booleans()):
        fields.append(Field(draw(st.sampled_from(["intensity", "i", "reflectivity"])), draw(datatypes), 1, draw(gaps)))
    if draw(st.booleans()):
        fields.append(Field(draw(st.sampled_from(["ring", "line", "channel"])), draw(st.sampled_from([2, 4])), 1, 0))
    if draw(st.booleans()):
        kind = draw(st.sampled_from([6, 7]))
        fields.append(Field(draw(st.sampled_from(["t", "time", "offset_time", "time_stamp"])), kind, 1, draw(gaps)))
    for k in range(draw(st.integers(0, 3))):
        fields.append(Field(f"other{k}", draw(datatypes), draw(st.integers(1, 3)), draw(gaps)))
    order = draw(st.permutations(fields))
    size = st.integers(1, 4)
    return Layout(tuple(order), draw(size), draw(size), draw(gaps), draw(gaps), draw(st.booleans()), draw(gaps))


def number(field: Field, index: int) -> list[float]:
    """A value that every type of field can hold, another for each field, point and element."""
    base = (sum(map(ord, field.name)) * 7 + index * 3) % 100
    return [base + k if field.datatype not in (7, 8) else (base + k) / 4 for k in range(field.elements)]


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=150, deadline=None)
@given(layout=layouts())
def test_any_layout_is_read_like_a_loop_reads_it(layout: Layout, ros_message: Make) -> None:
    cloud = decode_point_cloud(ros_message(CLOUD, cloud_fields(layout, number)))
    by_name = {field.name: field for field in layout.fields}
    count = layout.height * layout.width
    expected = [[number(by_name[name], index)[0] for name in "xyz"] for index in range(count)]
    np.testing.assert_array_equal(cloud.xyz, np.array(expected, np.float32))
    assert cloud.dropped_nonfinite == 0
    assert (cloud.stamp_ns, cloud.frame_id) == (STAMP_NS, "lidar")
    for values, names, unit in (
        (cloud.intensity, ("intensity", "i", "reflectivity"), 1.0),
        (cloud.ring, ("ring", "line", "channel"), 1.0),
        (cloud.time_s, ("t", "time", "offset_time", "time_stamp"), None),
    ):
        field = next((x for x in layout.fields if x.name in names), None)
        if field is None:
            assert values is None
            continue
        scale = unit or (1e-9 if field.datatype == 6 else 1.0)
        assert values is not None
        np.testing.assert_allclose(values, [number(field, k)[0] * scale for k in range(count)], rtol=1e-6)


def one_row(fields: tuple[Field, ...], columns: dict[str, list[float]], *, big_endian: bool = False) -> dict[str, Any]:
    """The message's fields of an unorganised cloud given by columns."""
    layout = Layout(fields, 1, len(columns["x"]), 0, 0, big_endian, 0)
    return cloud_fields(layout, lambda field, index: [columns[field.name][index]])


XYZ = (Field("x", 7), Field("y", 7), Field("z", 7))
ORIGIN: dict[str, list[float]] = {"x": [0.0, 1.0, 2.0], "y": [0.0] * 3, "z": [0.0] * 3}


def with_times(name: str, datatype: int, times: list[float], make: Make) -> PointCloud:
    fields = one_row((*XYZ, Field(name, datatype)), {**ORIGIN, name: times})
    return decode_point_cloud(make(CLOUD, fields))


@pytest.mark.parametrize(
    ("name", "datatype", "recorded", "seconds"),
    [
        ("t", 6, [0, 50_000_000, 99_999_999], [0.0, 0.05, 0.099999999]),
        ("time", 7, [-0.1, -0.05, 0.0], [-0.1, -0.05, 0.0]),
        ("timestamp", 8, [-0.1, -0.05, 0.0], [-0.1, -0.05, 0.0]),
        ("timestamp", 8, [STAMP_NS / 1e9 + dt for dt in (-0.1, 0.0, 0.05)], [-0.1, 0.0, 0.05]),
        ("timestamp", 8, [STAMP_NS + dt for dt in (0, 10**7, 10**8)], [0.0, 0.01, 0.1]),
        ("timestamp", 8, [1.0e9 + dt for dt in (7.0, 7.05, 7.1)], [0.0, 0.05, 0.1]),
        ("time_stamp", 6, [0, 1000, 2000], [0.0, 1e-6, 2e-6]),
        ("timestamp", 10, [STAMP_NS + dt for dt in (0, 10**7, 10**8)], [0.0, 0.01, 0.1]),
        ("t", 9, [-(10**8), 0, 10**7], [-0.1, 0.0, 0.01]),
    ],
    ids=["ouster", "velodyne", "relative double", "hesai", "livox", "another clock", "autoware", "lyrical", "pcl"],
)
def test_the_times_of_each_driver_become_seconds_from_the_header(
    name: str, datatype: int, recorded: list[float], seconds: list[float], ros_message: Make
) -> None:
    time_s = with_times(name, datatype, recorded, ros_message).time_s
    assert time_s is not None
    np.testing.assert_allclose(time_s, seconds, atol=1e-6)


def test_points_that_are_not_finite_are_dropped_with_all_they_have(ros_message: Make) -> None:
    columns = {
        "x": [0.0, math.nan, 2.0, 3.0, 4.0],
        "y": [0.0, 1.0, math.inf, 3.0, 4.0],
        "z": [0.0, 1.0, 2.0, -math.inf, 4.0],
        "intensity": [10.0, 11.0, 12.0, 13.0, 14.0],
        "ring": [0.0, 1.0, 2.0, 3.0, 4.0],
        "time": [0.0, 0.1, 0.2, 0.3, 0.4],
    }
    fields = (*XYZ, Field("intensity", 7), Field("ring", 7), Field("time", 7))
    cloud = decode_point_cloud(ros_message(CLOUD, one_row(fields, columns)))
    assert cloud.dropped_nonfinite == 3
    assert cloud.xyz.tolist() == [[0, 0, 0], [4, 4, 4]]
    assert cloud.intensity is not None
    assert cloud.ring is not None
    assert cloud.time_s is not None
    assert cloud.intensity.tolist() == [10, 14]
    assert cloud.ring.tolist() == [0, 4]
    np.testing.assert_allclose(cloud.time_s, [0.0, 0.4], rtol=1e-6)


@pytest.mark.parametrize("far_m", [1e300, 3e38, 2e9])
def test_a_coordinate_beyond_all_measure_counts_as_not_finite(far_m: float, ros_message: Make) -> None:
    columns = {"x": [1.0, 0.0, 0.0], "y": [0.0, far_m, 0.0], "z": [0.0, 0.0, -far_m]}
    cloud = decode_point_cloud(ros_message(CLOUD, one_row(tuple(Field(n, 8) for n in "xyz"), columns)))
    assert (cloud.xyz.tolist(), cloud.dropped_nonfinite) == ([[1, 0, 0]], 2)


def test_rings_that_cannot_be_rings_are_left_out(ros_message: Make) -> None:
    cases: list[tuple[int, list[float]]] = [(5, [0, 1, -1]), (5, [0, 1, 65536]), (7, [0, 1, math.nan])]
    for datatype, values in cases:
        fields = one_row((*XYZ, Field("ring", datatype)), {**ORIGIN, "ring": values})
        assert decode_point_cloud(ros_message(CLOUD, fields)).ring is None


def test_intensity_comes_before_reflectivity_and_upper_case_is_accepted(ros_message: Make) -> None:
    fields = tuple(Field(name, 7) for name in ("X", "Y", "Z", "reflectivity", "Intensity"))
    columns = {"x": [0.0], "X": [1.0], "Y": [2.0], "Z": [3.0], "reflectivity": [4.0], "Intensity": [5.0]}
    cloud = decode_point_cloud(ros_message(CLOUD, one_row(fields, columns)))
    assert cloud.xyz.tolist() == [[1, 2, 3]]
    assert cloud.intensity is not None
    assert cloud.intensity.tolist() == [5]


def test_a_count_of_zero_means_one_as_some_drivers_write_it(ros_message: Make) -> None:
    fields = one_row(XYZ, ORIGIN)
    fields["fields"] = [{**field, "count": 0} for field in fields["fields"]]
    assert decode_point_cloud(ros_message(CLOUD, fields)).xyz[:, 0].tolist() == [0, 1, 2]


@pytest.mark.parametrize("change", [{"width": 0}, {"height": 0}, {"point_step": 0}, {"point_step": 0, "fields": []}])
def test_an_empty_cloud_has_no_points(change: dict[str, Any], ros_message: Make) -> None:
    fields = one_row((*XYZ, Field("intensity", 2)), {**ORIGIN, "intensity": [1, 2, 3]})
    cloud = decode_point_cloud(ros_message(CLOUD, {**fields, "row_step": 0, "data": np.zeros(0), **change}))
    assert cloud.xyz.shape == (0, 3)
    assert (cloud.intensity is None) == ("fields" in change)
    assert cloud.dropped_nonfinite == 0


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"data": np.zeros(35)}, "truncated point cloud: 35 bytes, but its size needs 36"),
        ({"point_step": 11, "data": np.zeros(35)}, "field z ends at byte 12 of a point, but point_step is 11"),
        ({"point_step": 0, "width": 4}, "point_step is 0"),
        ({"fields": [{"name": "x", "datatype": 7, "count": 1}]}, "without the field y, z; it has x"),
        ({"fields": []}, "without the field x, y, z; it has none"),
    ],
)
def test_a_faulty_cloud_is_refused_with_the_reason(change: dict[str, Any], told: str, ros_message: Make) -> None:
    with pytest.raises(DatasetsError, match=told):
        decode_point_cloud(ros_message(CLOUD, {**one_row(XYZ, ORIGIN), **change}))


@pytest.mark.parametrize(("datatype", "count", "told"), [(12, 1, "unknown datatype 12"), (7, 3, "3 values a point")])
def test_a_faulty_field_is_refused_only_where_it_is_used(
    datatype: int, count: int, told: str, ros_message: Make
) -> None:
    layout = Layout(XYZ, 1, 3, 12, 0, False, 0)
    fields = cloud_fields(layout, lambda field, index: ORIGIN[field.name][index : index + 1])
    odd = {"name": "odd", "offset": 12, "datatype": datatype, "count": count}
    cloud = decode_point_cloud(ros_message(CLOUD, {**fields, "fields": [*fields["fields"], odd]}))
    assert len(cloud.xyz) == 3
    with pytest.raises(DatasetsError, match=told):
        decode_point_cloud(ros_message(CLOUD, {**fields, "fields": [*fields["fields"], {**odd, "name": "ring"}]}))


GRID = Layout((*XYZ, Field("ring", 4)), 3, 4, 6, 0, False, 0)
"""Twelve points of 20 bytes in three rows, six of them padding."""


@pytest.mark.parametrize("row_step", [0, 4, 79, 240, 10_000])
def test_a_row_step_is_not_believed_against_the_bytes(row_step: int, ros_message: Make) -> None:
    fields = cloud_fields(GRID, number)
    right = decode_point_cloud(ros_message(CLOUD, fields))
    cloud = decode_point_cloud(ros_message(CLOUD, {**fields, "row_step": row_step}))
    np.testing.assert_array_equal(cloud.xyz, right.xyz)
    np.testing.assert_array_equal(cloud.ring, right.ring)
    assert [note.code for note in cloud.notes] == ["cloud.size-misfit"]
    assert not right.notes


@pytest.mark.parametrize(
    "change",
    [
        {"width": 20, "height": 1, "row_step": 240},
        {"width": 5, "height": 1, "row_step": 240},
        {"width": 12, "height": 2},
        {"width": 12, "height": 0},
        {"width": 0, "height": 0},
        {"point_step": 0},
        {"point_step": 21},
    ],
    ids=str,
)
def test_what_fits_the_bytes_counts_against_width_height_and_point_step(
    change: dict[str, int], ros_message: Make
) -> None:
    fields = cloud_fields(GRID, number)
    right = decode_point_cloud(ros_message(CLOUD, fields))
    # Where point_step alone is wrong, the others leave 20 bytes for each of twelve points.
    cloud = decode_point_cloud(ros_message(CLOUD, {**fields, **change}))
    np.testing.assert_array_equal(cloud.xyz, right.xyz)
    assert "cloud.size-misfit" in {note.code for note in cloud.notes}


@pytest.mark.parametrize("row_step", [0, 400, 5])
def test_rows_with_padding_are_found_without_their_step(row_step: int, ros_message: Make) -> None:
    fields = cloud_fields(GRID._replace(row_padding=7), number)
    right = decode_point_cloud(ros_message(CLOUD, fields))
    cloud = decode_point_cloud(ros_message(CLOUD, {**fields, "row_step": row_step}))
    np.testing.assert_array_equal(cloud.xyz, right.xyz)
    assert [note.code for note in cloud.notes] == ["cloud.size-misfit"]


@pytest.mark.parametrize(("tail", "said"), [(50, 24), (2, 40), (2, 30), (2, 24)])
def test_a_point_step_is_not_believed_against_width_row_step_and_bytes(tail: int, said: int, ros_message: Make) -> None:
    fields = cloud_fields(GRID._replace(tail=tail), number)
    right = decode_point_cloud(ros_message(CLOUD, fields))
    cloud = decode_point_cloud(ros_message(CLOUD, {**fields, "point_step": said}))
    np.testing.assert_array_equal(cloud.xyz, right.xyz)
    assert [note.code for note in cloud.notes] == ["cloud.size-misfit"]
    assert not right.notes


def test_padding_of_points_and_rows_and_bytes_behind_the_last_row_are_no_misfit(ros_message: Make) -> None:
    padded = cloud_fields(GRID._replace(row_padding=7), number)
    longer = {**padded, "data": np.concatenate([padded["data"], np.zeros(33, np.uint8)])}
    shorter = {**padded, "data": padded["data"][:-7]}
    for fields in (padded, longer, shorter):
        cloud = decode_point_cloud(ros_message(CLOUD, fields))
        assert (len(cloud.xyz), cloud.notes) == (12, ())


def test_a_count_without_room_for_it_is_one(ros_message: Make) -> None:
    fields = cloud_fields(GRID, number)
    fields["fields"] = [{**field, "count": 12} for field in fields["fields"]]
    cloud = decode_point_cloud(ros_message(CLOUD, fields))
    np.testing.assert_array_equal(cloud.xyz, decode_point_cloud(ros_message(CLOUD, cloud_fields(GRID, number))).xyz)
    assert "cloud.size-misfit" in {note.code for note in cloud.notes}


def test_a_flag_a_point_is_no_hindrance_and_far_doubles_are_told(ros_message: Make) -> None:
    doubles = (*(Field(name, 8) for name in "xyz"), Field("is_ground", 2))
    columns: dict[str, list[float]] = {"x": [0.25, 1.5], "y": [2.0, 3.0], "z": [4.0, 5.0], "is_ground": [1, 0]}
    fields = one_row(doubles, columns)
    fields["fields"][-1]["datatype"] = 11
    cloud = decode_point_cloud(ros_message(CLOUD, fields))
    assert (cloud.xyz[:, 0].tolist(), cloud.notes) == ([0.25, 1.5], ())
    far = decode_point_cloud(ros_message(CLOUD, one_row(doubles, {**columns, "x": [5e5, 1.5]})))
    assert [note.code for note in far.notes] == ["cloud.far"]
