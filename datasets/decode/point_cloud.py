"""``sensor_msgs/PointCloud2``: points of any layout, with intensity, ring and time where it has them."""

from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float32, Shaped, UInt16

from navtool.base.errors import DatasetsError
from navtool.base.note import Note
from navtool.datasets.decode.cloud_bytes import MISFIT, Said, layout_of
from navtool.datasets.decode.finite_cloud import finite_cloud
from navtool.datasets.decode.header import head_of
from navtool.datasets.decode.messages import PointCloud
from navtool.datasets.decode.point_time import seconds_from_header
from navtool.pipeline.arrays import Array

INTENSITY_NAMES = ("intensity", "intensities", "i", "reflectivity")
RING_NAMES = ("ring", "line", "channel")
TIME_NAMES = ("t", "time", "timestamp", "offset_time", "time_stamp")
_DATATYPES = dict(enumerate(("i1", "u1", "i2", "u2", "i4", "u4", "f4", "f8", "i8", "u8", "?"), start=1))
"""The last three as PCL has long numbered them, and ROS since Lyrical."""
_FAR_M = 10_000.0


class _Fields(NamedTuple):
    """Names, among the fields of the message, of those that are used."""

    xyz: tuple[str, str, str]
    intensity: str | None
    ring: str | None
    time: str | None

    def names(self) -> set[str]:
        return {*self.xyz, *(x for x in self[1:] if x)}


def decode_point_cloud(message: Any) -> PointCloud:
    """The points in the order recorded, row by row, without those that have a NaN or infinite coordinate.

    Sizes that contradict each other are not believed against the bytes; what was read instead is noted.

    Raises:
        DatasetsError: A coordinate's field is missing, a field lies outside its point, or nothing that the cloud says
            of its size fits its bytes.
    """
    # A double beyond single precision becomes infinite, and is dropped with the others.
    with np.errstate(over="ignore", invalid="ignore"):
        return _decoded(message)


def _decoded(message: Any) -> PointCloud:
    head = head_of(message)
    fields = _fields(message)
    points, notes = _points(message, fields.names())
    columns = np.empty((3, points.size), np.float32)
    for column, name in zip(columns, fields.xyz, strict=True):
        column.reshape(points.shape)[...] = points[name]
    intensity = None if fields.intensity is None else points[fields.intensity].astype(np.float32).reshape(-1)
    ring = None if fields.ring is None else ring_numbers(points[fields.ring].reshape(-1))
    time_s = None if fields.time is None else seconds_from_header(points[fields.time].reshape(-1), head.stamp_ns or 0)
    return finite_cloud(head, columns, intensity, ring, time_s, (*notes, *_far_notes(points, fields, columns)))


def _far_notes(points: Shaped[Array, "h w"], fields: _Fields, columns: Float32[Array, "3 n"]) -> tuple[Note, ...]:
    """A note where doubles hold what single precision does not."""
    if columns.size == 0 or points.dtype[fields.xyz[0]].itemsize < 8:
        return ()
    finite = columns[np.isfinite(columns)]
    if not finite.size or np.abs(finite).max() < _FAR_M:
        return ()
    what = "points lie beyond 10 km of their frame's origin: in single precision they are off by millimetres and more"
    return (Note("cloud.far", what),)


def _fields(message: Any) -> _Fields:
    # Autoware's drivers of one generation write upper case.
    names = {x.name.lower(): x.name for x in reversed(message.fields)}
    empty = message.width * message.height == 0 or (message.point_step == 0 and message.data.nbytes == 0)
    missing = [name for name in "xyz" if name not in names]
    if missing and not empty:
        raise DatasetsError(
            f"a point cloud without the field {', '.join(missing)}; it has {', '.join(names.values()) or 'none'}",
            cure="map a topic with Cartesian points",
        )
    xyz = (names.get("x", "x"), names.get("y", "y"), names.get("z", "z"))
    return _Fields(
        xyz,
        *(next((names[x] for x in known if x in names), None) for known in (INTENSITY_NAMES, RING_NAMES, TIME_NAMES)),
    )


def _points(message: Any, used: set[str]) -> tuple[Shaped[Array, "h w"], tuple[Note, ...]]:
    """A structured view of the message's bytes with the used fields only, and what is odd about them."""
    order = ">" if message.is_bigendian else "<"
    size = message.data.nbytes
    if size == 0 and (message.width * message.height == 0 or message.point_step == 0):
        kinds = {x.name: f"{order}{_DATATYPES.get(x.datatype, 'f4')}" for x in message.fields}
        return np.empty((0, 0), np.dtype([(name, kinds.get(name, "f4")) for name in sorted(used)])), ()
    places, notes = _places(message, used, order)
    last = max(places, key=lambda place: place.end)
    width, height, step, row_step = map(int, (message.width, message.height, message.point_step, message.row_step))
    layout = layout_of(Said(width, height, step, row_step, size, last.end, last.name))
    dtype = np.dtype(
        {
            "names": [place.name for place in places],
            "formats": [place.kind for place in places],
            "offsets": [place.offset for place in places],
            "itemsize": layout.point_step,
        }
    )
    strides = (layout.row_step, layout.point_step)
    points: Array = np.ndarray((layout.height, layout.width), dtype, buffer=message.data, strides=strides)
    return points, (*notes, *layout.notes)


class _Place(NamedTuple):
    """Where the value of a used field lies in a point."""

    name: str
    kind: np.dtype[Any]
    offset: int

    @property
    def end(self) -> int:
        return self.offset + self.kind.itemsize


def _places(message: Any, used: set[str], order: str) -> tuple[list[_Place], tuple[Note, ...]]:
    places: dict[str, _Place] = {}
    starts = sorted({int(field.offset) for field in message.fields})
    notes: dict[str, Note] = {}
    for field in message.fields:
        if field.name not in used or field.name in places:
            continue
        if field.datatype not in _DATATYPES:
            raise DatasetsError(f"field {field.name} has the unknown datatype {field.datatype}; 1 to 11 are defined")
        place = _Place(field.name, np.dtype(f"{order}{_DATATYPES[field.datatype]}"), int(field.offset))
        # Some drivers leave the count at 0.
        if field.count > 1:
            room = next((x for x in starts if x > place.offset), int(message.point_step)) - place.offset
            if room >= field.count * place.kind.itemsize:
                raise DatasetsError(f"field {field.name} has {field.count} values a point, where one is expected")
            what = f"field {field.name} counts {field.count} values a point, where there is room for one; one is read"
            notes[field.name] = Note(MISFIT, what)
        places[field.name] = place
    return list(places.values()), tuple(notes.values())


def ring_numbers(ring: Shaped[Array, " n"]) -> UInt16[Array, " n"] | None:
    """The laser of each point; None where the values cannot be such numbers."""
    if ring.dtype.kind == "u" and ring.dtype.itemsize <= 2:
        return ring.astype(np.uint16)
    if ring.size and not (np.min(ring) >= 0 and np.max(ring) <= np.iinfo(np.uint16).max):
        return None
    return ring.astype(np.uint16)
