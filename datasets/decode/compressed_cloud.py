"""``CompressedPointCloud2`` of point_cloud_transport: a PointCloud2 whose points were packed by Draco, zlib or zstd."""

import zlib
from types import SimpleNamespace
from typing import Any

import numpy as np
import zstandard

from navtool.base.errors import DatasetsError
from navtool.datasets.decode.messages import PointCloud
from navtool.datasets.decode.point_cloud import decode_point_cloud

_DRACO, _ZSTD = b"DRACO", b"\x28\xb5\x2f\xfd"
_MOST_BYTES = 1 << 28
"""No LiDAR's cloud is larger."""
_COLOURS = ("rgb", "rgba")
_DATATYPES = {"u1": 2, "i1": 1, "i2": 3, "u2": 4, "i4": 5, "u4": 6, "f4": 7, "f8": 8, "i8": 9, "u8": 10}


def decode_compressed_cloud(message: Any) -> PointCloud:
    """The points as a PointCloud2 of the same fields has them; Draco may have changed their order and rounded them.

    Raises:
        DatasetsError: Draco's library is not installed, the compression is another, or the data are damaged.
    """
    data = bytes(message.compressed_data)
    if not data:
        return decode_point_cloud(_like(message, np.zeros(0, np.uint8)))
    if data.startswith(_DRACO):
        return decode_point_cloud(_of_draco(message, data))
    if data.startswith(_ZSTD):
        return decode_point_cloud(_like(message, np.frombuffer(_zstd(data), np.uint8)))
    if data[0] & 0x0F == zlib.DEFLATED and not int.from_bytes(data[:2]) % 31:
        return decode_point_cloud(_like(message, np.frombuffer(_zlib(data), np.uint8)))
    form = getattr(message, "format", "") or "unknown"
    raise DatasetsError(
        f"a point cloud compressed as {form!r}, which is not decoded; draco, zlib and zstd are",
        cure="record its PointCloud2",
    )


def _like(message: Any, data: Any, **changes: Any) -> SimpleNamespace:
    """The message as it was before it was compressed."""
    names = ("header", "height", "width", "fields", "is_bigendian", "point_step", "row_step")
    return SimpleNamespace(**{name: getattr(message, name) for name in names} | {"data": data} | changes)


def _zlib(data: bytes) -> bytes:
    stream = zlib.decompressobj()
    try:
        content = stream.decompress(data, _MOST_BYTES)
    except zlib.error as error:
        raise DatasetsError(f"damaged point cloud: it cannot be decompressed ({error})") from error
    if not stream.eof:
        raise DatasetsError(f"damaged point cloud: its {len(data)} compressed bytes are not all of it")
    return content


def _zstd(data: bytes) -> bytes:
    try:
        if zstandard.frame_content_size(data) > _MOST_BYTES:
            raise DatasetsError("damaged point cloud: it says that it is larger than any LiDAR's")
        # A stream's reader would take the part of a frame for all of it.
        return zstandard.ZstdDecompressor().decompress(data, max_output_size=_MOST_BYTES)
    except zstandard.ZstdError as error:
        raise DatasetsError(f"damaged point cloud: it cannot be decompressed ({error})") from error


def _of_draco(message: Any, data: bytes) -> SimpleNamespace:
    try:
        import DracoPy  # noqa: PLC0415 - an extra
    except ModuleNotFoundError as error:
        raise DatasetsError(
            "a point cloud compressed by Draco, whose library is not installed", cure="pip install 'navtool[draco]'"
        ) from error
    try:
        attributes = DracoPy.decode(data).attributes
    except Exception as error:
        raise DatasetsError(f"damaged point cloud: Draco cannot decode it ({error})") from error
    columns = _columns([str(field.name) for field in message.fields], [np.asarray(x["data"]) for x in attributes])
    points = len(next(iter(columns.values()))) if columns else 0
    table = np.zeros(points, [(name, values.dtype.newbyteorder("<")) for name, values in columns.items()])
    for name, values in columns.items():
        table[name] = values
    places: Any = table.dtype.fields or {}
    fields = [
        SimpleNamespace(name=name, offset=places[name][1], datatype=_DATATYPES[values.dtype.str[1:]], count=1)
        for name, values in columns.items()
    ]
    step = table.dtype.itemsize
    size = {"height": 1, "width": points, "point_step": step, "row_step": points * step}
    raw = np.frombuffer(table.tobytes(), np.uint8)
    return _like(message, raw, fields=fields, is_bigendian=False, **size)


def _columns(names: list[str], attributes: list[Any]) -> dict[str, Any]:
    """The values of each field: an attribute stands for as many fields as it has components, for one of a colour.

    Raises:
        DatasetsError: There are more fields than attributes.
    """
    columns: dict[str, Any] = {}
    left = list(names)
    for values in attributes:
        table = values.reshape(len(values), -1)
        if left and left[0] in _COLOURS:
            left.pop(0)
            continue
        for component in table.T:
            if left and component.dtype.str[1:] in _DATATYPES:
                columns[left.pop(0)] = component
    if left:
        raise DatasetsError(f"damaged point cloud: Draco's data lack {', '.join(left)}")
    return columns
