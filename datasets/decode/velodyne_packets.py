"""``velodyne_msgs/VelodyneScan``: raw packets of a VLP-16, decoded as the sensor's manual describes them.

Reference: Velodyne LiDAR, "VLP-16 User Manual", 63-9243, section 9: packets of 12 blocks, each a flag, an azimuth and
two firings of 16 lasers.
"""

from typing import Any

import numpy as np
from jaxtyping import Float64, Int64, Shaped

from navtool.base.errors import DatasetsError
from navtool.datasets.decode.header import head_of
from navtool.datasets.decode.messages import PointCloud
from navtool.pipeline.arrays import Array

PACKET_BYTES = 1206
_BLOCKS, _FIRINGS, _LASERS = 12, 2, 16
_FLAG = 0xEEFF
_TURN = 36_000
_DISTANCE_M = 0.002
_FIRING_S, _LASER_S = 55.296e-6, 2.304e-6
_BLOCK_S = _FIRINGS * _FIRING_S
_DUAL = 0x39
_VLP16 = 0x22
_PRODUCTS = {0x21: "HDL-32E", 0x22: "VLP-16", 0x24: "Puck Hi-Res", 0x28: "VLP-32C", 0x31: "Velarray", 0x42: "VLS-128"}
_ELEVATION_RAD = np.radians([-15.0, 1, -13, 3, -11, 5, -9, 7, -7, 9, -5, 11, -3, 13, -1, 15])
_RING = np.argsort(np.argsort(_ELEVATION_RAD)).astype(np.uint16)
"""Lasers counted from the lowest up, as the ROS driver counts them."""
_HEIGHT_M = np.array([11.2, -0.7, 9.7, -2.2, 8.1, -3.7, 6.6, -5.1, 5.1, -6.6, 3.7, -8.1, 2.2, -9.7, 0.7, -11.2]) * 1e-3
"""How far above the sensor's centre each laser's beam leaves it (manual, appendix F)."""
_BLOCK = np.dtype(
    [("flag", "<u2"), ("azimuth", "<u2"), ("returns", [("distance", "<u2"), ("intensity", "u1")], (_FIRINGS, _LASERS))]
)
_PACKET = np.dtype([("blocks", _BLOCK, (_BLOCKS,)), ("since_hour_us", "<u4"), ("mode", "u1"), ("product", "u1")])


def decode_velodyne_scan(message: Any) -> PointCloud:
    """The points of a scan's packets, in the order of firing; x forward, y left, z up, as the ROS driver turns them.

    Beams without a return are left out. Of a sensor set to two returns a beam both are points, where they differ.
    Intensity is the calibrated reflectivity, 0 to 255. Times are those of the firings, from the header's stamp.

    Raises:
        DatasetsError: No packets, packets of another size, or of another sensor than a VLP-16.
    """
    head = head_of(message)
    packets, starts_s = _packets(message, head.stamp_ns or 0)
    dual = packets["mode"] == _DUAL
    blocks = packets["blocks"]
    distance = blocks["returns"]["distance"].astype(np.float64) * _DISTANCE_M
    there = (distance > 0) & (blocks["flag"] == _FLAG)[..., None, None]
    if dual.any():
        there &= ~_repeated(blocks, dual)
    azimuth, offset_s = _aim(blocks["azimuth"].astype(np.int64), dual)
    level = distance * np.cos(_ELEVATION_RAD)
    xyz = np.stack(
        [
            level * np.cos(azimuth),
            -level * np.sin(azimuth),
            distance * np.sin(_ELEVATION_RAD) + _HEIGHT_M,
        ],
        axis=-1,
    )
    time_s = starts_s[:, None, None, None] + offset_s
    ring = np.broadcast_to(_RING, distance.shape)
    return PointCloud(
        **head._asdict(),
        xyz=xyz[there].astype(np.float32),
        intensity=blocks["returns"]["intensity"][there].astype(np.float32),
        ring=ring[there],
        time_s=time_s[there].astype(np.float32),
        dropped_nonfinite=0,
    )


def _packets(message: Any, stamp_ns: int) -> tuple[Shaped[Array, " packets"], Float64[Array, " packets"]]:
    """The packets' contents, and when each began from the header's stamp in seconds."""
    packets = message.packets
    if not len(packets):
        raise DatasetsError("a scan without packets")
    data = packets["data"]
    if data.shape[1] != PACKET_BYTES:
        raise DatasetsError(f"packets of {data.shape[1]} bytes; a VLP-16's have {PACKET_BYTES}")
    content = np.ascontiguousarray(data, np.uint8).view(_PACKET)[:, 0]
    products = sorted(set(content["product"].tolist()) - {_VLP16})
    if products:
        names = ", ".join(_PRODUCTS.get(product, f"product {product:#04x}") for product in products)
        raise DatasetsError(
            f"packets of another sensor: {names}; VLP-16 is decoded", cure="record its PointCloud2, from its own driver"
        )
    stamps = packets["stamp"]
    sec, nanosec = (stamps[name].astype(np.int64) for name in stamps.dtype.names)
    return content, (sec * 1_000_000_000 + nanosec - stamp_ns) * 1e-9


def _repeated(blocks: Shaped[Array, "packets blocks"], dual: Shaped[Array, " packets"]) -> Shaped[Array, "*n"]:
    """Where the second of two returns a beam is the first again."""
    returns = blocks["returns"]
    same = np.zeros(returns.shape, dtype=np.bool_)
    same[:, 1::2] = (returns["distance"][:, 1::2] == returns["distance"][:, ::2]) & dual[:, None, None, None]
    return same


def _aim(
    azimuth: Int64[Array, "packets blocks"], dual: Shaped[Array, " packets"]
) -> tuple[Float64[Array, "packets blocks firings lasers"], Float64[Array, "packets blocks firings lasers"]]:
    """Direction and time of every firing: the head turns on between two blocks' azimuths; the last block's as before.

    Blocks of a sensor set to two returns come in pairs of one azimuth and one time.
    """
    step = np.where(dual, 2, 1)[:, None]
    firing = np.arange(_BLOCKS)[None] // step
    last = (_BLOCKS // step) - 1
    following = np.minimum(firing + 1, last) * step
    before = np.minimum(firing, last - 1) * step
    first = np.take_along_axis(azimuth, before, axis=1)
    second = np.take_along_axis(azimuth, np.where(firing < last, following, last * step), axis=1)
    turned = (second - first) % _TURN
    within = np.arange(_FIRINGS)[:, None] * _FIRING_S + np.arange(_LASERS)[None] * _LASER_S
    angle = azimuth[..., None, None] + turned[..., None, None] * (within / _BLOCK_S)
    return np.radians(angle / 100.0), firing[..., None, None] * _BLOCK_S + within
