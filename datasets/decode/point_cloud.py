"""``sensor_msgs/PointCloud2``: points of any layout, with intensity, ring and time where it has them."""

from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Shaped, UInt16

from navtool.base.errors import DatasetsError
from navtool.datasets.decode.finite_cloud import finite_cloud
from navtool.datasets.decode.header import head_of
from navtool.datasets.decode.messages import PointCloud
from navtool.datasets.decode.point_time import seconds_from_header
from navtool.pipeline.arrays import Array

INTENSITY_NAMES = ("intensity", "intensities", "i", "reflectivity")
RING_NAMES = ("ring", "line", "channel")
TIME_NAMES = ("t", "time", "timestamp", "offset_time", "time_stamp")
_DATATYPES = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 8: "f8"}


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

    Raises:
        DatasetsError: A coordinate's field is missing, a field lies outside its point, or there are fewer bytes than
            the cloud's size says.
    """
    # A double beyond single precision becomes infinite, and is dropped with the others.
    with np.errstate(over="ignore", invalid="ignore"):
        return _decoded(message)


def _decoded(message: Any) -> PointCloud:
    head = head_of(message)
    fields = _fields(message)
    points = _points(message, fields.names())
    columns = np.empty((3, points.size), np.float32)
    for column, name in zip(columns, fields.xyz, strict=True):
        column.reshape(points.shape)[...] = points[name]
    intensity = None if fields.intensity is None else points[fields.intensity].astype(np.float32).reshape(-1)
    ring = None if fields.ring is None else ring_numbers(points[fields.ring].reshape(-1))
    time_s = None if fields.time is None else seconds_from_header(points[fields.time].reshape(-1), head.stamp_ns or 0)
    return finite_cloud(head, columns, intensity, ring, time_s)


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


def _points(message: Any, used: set[str]) -> Shaped[Array, "h w"]:
    """A structured view of the message's bytes with the used fields only."""
    width, height, step, row_step = (
        int(x) for x in (message.width, message.height, message.point_step, message.row_step)
    )
    order = ">" if message.is_bigendian else "<"
    if width * height == 0 or (step == 0 and message.data.nbytes == 0):
        kinds = {x.name: f"{order}{_DATATYPES.get(x.datatype, 'f4')}" for x in message.fields}
        return np.empty((0, 0), np.dtype([(name, kinds.get(name, "f4")) for name in sorted(used)]))
    dtype = _dtype(message, used, order)
    if row_step < width * step and height > 1:
        raise DatasetsError(f"row_step is {row_step} bytes, but a row of {width} points takes {width * step}")
    needed = row_step * (height - 1) + width * step
    if message.data.nbytes < needed:
        raise DatasetsError(f"truncated point cloud: {message.data.nbytes} bytes, but its size needs {needed}")
    return np.ndarray((height, width), dtype, buffer=message.data, strides=(row_step, step))


def _dtype(message: Any, used: set[str], order: str) -> np.dtype[np.void]:
    names, formats, offsets = [], [], []
    for field in message.fields:
        if field.name not in used or field.name in names:
            continue
        if field.datatype not in _DATATYPES:
            raise DatasetsError(f"field {field.name} has the unknown datatype {field.datatype}; 1 to 8 are defined")
        # Some drivers leave the count at 0.
        if field.count > 1:
            raise DatasetsError(f"field {field.name} has {field.count} values a point, where one is expected")
        kind = np.dtype(f"{order}{_DATATYPES[field.datatype]}")
        if field.offset + kind.itemsize > message.point_step:
            raise DatasetsError(
                f"field {field.name} ends at byte {field.offset + kind.itemsize} of a point, "
                f"but point_step is {message.point_step}"
            )
        names.append(field.name)
        formats.append(kind)
        offsets.append(int(field.offset))
    return np.dtype({"names": names, "formats": formats, "offsets": offsets, "itemsize": int(message.point_step)})


def ring_numbers(ring: Shaped[Array, " n"]) -> UInt16[Array, " n"] | None:
    """The laser of each point; None where the values cannot be such numbers."""
    if ring.dtype.kind == "u" and ring.dtype.itemsize <= 2:
        return ring.astype(np.uint16)
    if ring.size and not (np.min(ring) >= 0 and np.max(ring) <= np.iinfo(np.uint16).max):
        return None
    return ring.astype(np.uint16)
