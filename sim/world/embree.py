"""Embree's tree of triangles, asked sixteen rays at a time.

The wheel embreex carries the library. Its own binding asks for one ray at a time; packets of rays that go nearly the
same way, as those of neighbouring pixels and beams do, take half the time.
"""

import ctypes
import re
import weakref
from functools import lru_cache
from importlib.metadata import PackageNotFoundError, files
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float32, Int32

from navtool.pipeline.arrays import Array
from navtool.sim.errors import SimError

_WIDTH = 16
_PACKETS = 256
"""In a batch: its rays stay in the processor's second cache."""
_ALIGNMENT = 64
_ORIGIN, _DIRECTION, _FAR, _MASK, _RAY_FIELDS = 0, 4, 8, 9, 12
_U, _V, _TRIANGLE, _GEOMETRY, _FIELDS = 15, 16, 17, 18, 21
"""Where a packet holds what, in sixteens of four bytes: RTCRay16, and RTCHit16 behind it."""
_TRIANGLES, _INDEX_BUFFER, _VERTEX_BUFFER, _UINT3, _FLOAT3 = 0, 0, 1, 0x5003, 0x9003
_COHERENT = 1 << 16


class FirstMet(NamedTuple):
    """What rays meet first."""

    distance: Float32[Array, " n"]
    """In lengths of the rays' directions; infinite for nothing."""
    triangle: Int32[Array, " n"]
    """-1 for nothing."""
    u: Float32[Array, " n"]
    """Like v, 0 for nothing."""
    v: Float32[Array, " n"]


class EmbreeTree:
    """Triangles that rays are cast against.

    Guarantee: equal triangles and rays give equal answers on one kind of processor; the tree is built by one thread.
    Only one thread at a time may ask: batches are packed into memory that is kept.
    """

    def __init__(self, vertices: Float32[Array, "v 3"], triangles: Int32[Array, "t 3"]) -> None:
        library, device = _library(), _device()
        self._scene: int = library.rtcNewScene(device)
        geometry = library.rtcNewGeometry(device, _TRIANGLES)
        points = library.rtcSetNewGeometryBuffer(geometry, _VERTEX_BUFFER, 0, _FLOAT3, 16, len(vertices))
        corners = library.rtcSetNewGeometryBuffer(geometry, _INDEX_BUFFER, 0, _UINT3, 12, len(triangles))
        if not points or not corners:
            raise SimError(f"Embree has no room for {len(triangles)} triangles", cure="make the place smaller")
        _memory(points, (len(vertices), 4), np.float32)[:, :3] = vertices
        _memory(corners, (len(triangles), 3), np.int32)[:] = triangles
        library.rtcCommitGeometry(geometry)
        library.rtcAttachGeometry(self._scene, geometry)
        library.rtcReleaseGeometry(geometry)
        library.rtcCommitScene(self._scene)
        weakref.finalize(self, library.rtcReleaseScene, self._scene)
        self._rays, self._shadow_rays = _packets(_FIELDS), _packets(_RAY_FIELDS)
        self._active = _aligned((_WIDTH,), np.int32)
        self._active[:] = -1
        error = library.rtcGetDeviceError(device)
        if error:
            raise SimError(f"Embree cannot take the triangles (its error {error})", cure="check that all are finite")

    def first_met(self, origins: Float32[Array, "n 3"], directions: Float32[Array, "n 3"]) -> FirstMet:
        """What each ray meets first; rays that follow each other had better go nearly the same way."""
        count = len(origins)
        distance, triangle = np.empty(count, np.float32), np.empty(count, np.int32)
        u, v = np.empty(count, np.float32), np.empty(count, np.float32)
        packets = self._rays
        numbers = packets.view(np.int32)
        for begin in range(0, count, _PACKETS * _WIDTH):
            part = slice(begin, begin + _PACKETS * _WIDTH)
            used = _fill(packets, origins[part], directions[part])
            numbers[:used, _TRIANGLE : _GEOMETRY + 1] = -1
            packets[:used, _U : _V + 1] = 0
            self._ask(_library().rtcIntersect16, packets[:used], coherent=True)
            size = len(origins[part])
            distance[part] = packets[:used, _FAR].reshape(-1)[:size]
            triangle[part] = numbers[:used, _TRIANGLE].reshape(-1)[:size]
            u[part], v[part] = (packets[:used, field].reshape(-1)[:size] for field in (_U, _V))
        return FirstMet(distance, triangle, u, v)

    def blocked(
        self, origins: Float32[Array, "n 3"], directions: Float32[Array, "n 3"], *, coherent: bool
    ) -> Bool[Array, " n"]:
        """Whether each ray meets anything.

        Args:
            origins: Where the rays begin.
            directions: Where they go.
            coherent: Whether rays that follow each other go nearly the same way: they are faster together.
        """
        found = np.empty(len(origins), bool)
        packets = self._shadow_rays
        for begin in range(0, len(origins), _PACKETS * _WIDTH):
            part = slice(begin, begin + _PACKETS * _WIDTH)
            used = _fill(packets, origins[part], directions[part])
            self._ask(_library().rtcOccluded16, packets[:used], coherent=coherent)
            found[part] = (packets[:used, _FAR] < 0).reshape(-1)[: len(origins[part])]
        return found

    def _ask(self, query: "ctypes._NamedFuncPointer", packets: Float32[Array, "m f w"], *, coherent: bool) -> None:
        arguments = _Arguments(_COHERENT if coherent else 0, 0xFFFFFFFF, None, None, None)
        first, step = packets.ctypes.data, packets.strides[0]
        everyone, options = self._active.ctypes.data, ctypes.addressof(arguments)
        for packet in range(first, first + len(packets) * step, step):
            query(everyone, self._scene, packet, options)


class _Arguments(ctypes.Structure):
    """RTCIntersectArguments and RTCOccludedArguments."""

    _fields_ = (
        ("flags", ctypes.c_int),
        ("feature_mask", ctypes.c_uint),
        ("context", ctypes.c_void_p),
        ("filter", ctypes.c_void_p),
        ("intersect", ctypes.c_void_p),
    )


def _fill(packets: Float32[Array, "m f w"], origins: Float32[Array, "n 3"], directions: Float32[Array, "n 3"]) -> int:
    """Enter a batch of rays, the last one as often as fills its packet; returns how many packets are used."""
    used = -(-len(origins) // _WIDTH)
    if len(origins) < used * _WIDTH:
        index = np.minimum(np.arange(used * _WIDTH), len(origins) - 1)
        origins, directions = origins[index], directions[index]
    for axis in range(3):
        packets[:used, _ORIGIN + axis] = origins[:, axis].reshape(used, _WIDTH)
        packets[:used, _DIRECTION + axis] = directions[:, axis].reshape(used, _WIDTH)
    packets[:used, _FAR] = np.inf
    return used


def _packets(fields: int) -> Float32[Array, "m f w"]:
    """Room for a batch of packets, with what is the same for all rays."""
    packets = _aligned((_PACKETS, fields, _WIDTH), np.float32)
    packets[:] = 0
    packets.view(np.int32)[:, _MASK] = -1
    return packets


def _aligned(shape: tuple[int, ...], kind: type[np.float32 | np.int32]) -> Array:
    """An array that begins where Embree wants it to."""
    size = 4 * int(np.prod(shape))
    room = np.empty(size + _ALIGNMENT, np.uint8)
    begin = -room.ctypes.data % _ALIGNMENT
    return room[begin : begin + size].view(kind).reshape(shape)


def _memory(address: int, shape: tuple[int, int], kind: type[np.float32 | np.int32]) -> Array:
    """Memory of the library as an array."""
    size = 4 * shape[0] * shape[1]
    return np.frombuffer((ctypes.c_char * size).from_address(address), kind).reshape(shape)


@lru_cache(maxsize=1)
def _device() -> int:
    """The one device of the process.

    With a second one, even after the first was released, a thread of Embree's begins to wait for work without rest: it
    takes a whole core from then on.
    """
    return int(_library().rtcNewDevice(b"threads=1"))


@lru_cache(maxsize=1)
def _library() -> ctypes.CDLL:
    """Embree, as the wheel carries it.

    Raises:
        SimError: It is not installed.
    """
    try:
        found = [path for path in files("embreex") or [] if re.search(r"embree4.*\.(so|dylib|dll)", path.name)]
    except PackageNotFoundError:
        found = []
    if not found:
        raise SimError("Embree is not installed", cure="install the extra sim: pip install navtool[sim]")
    import embreex.rtcore_scene  # noqa: F401, PLC0415  loads what the library itself needs

    library = ctypes.CDLL(str(found[0].locate()))
    pointer, size, number = ctypes.c_void_p, ctypes.c_size_t, ctypes.c_int
    signatures = {
        "rtcNewDevice": (pointer, ctypes.c_char_p),
        "rtcNewScene": (pointer, pointer),
        "rtcNewGeometry": (pointer, pointer, number),
        "rtcSetNewGeometryBuffer": (pointer, pointer, number, ctypes.c_uint, number, size, size),
        "rtcCommitGeometry": (None, pointer),
        "rtcAttachGeometry": (ctypes.c_uint, pointer, pointer),
        "rtcReleaseGeometry": (None, pointer),
        "rtcCommitScene": (None, pointer),
        "rtcReleaseScene": (None, pointer),
        "rtcGetDeviceError": (number, pointer),
        "rtcIntersect16": (None, pointer, pointer, pointer, pointer),
        "rtcOccluded16": (None, pointer, pointer, pointer, pointer),
    }
    for name, (result, *arguments) in signatures.items():
        function = getattr(library, name)
        function.restype, function.argtypes = result, arguments
    return library
