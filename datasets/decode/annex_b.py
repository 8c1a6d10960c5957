"""The units of an H.264 or H.265 stream: where they begin, of what kind they are, whether decoding can begin there."""

from collections.abc import Iterator
from typing import NamedTuple

_START = b"\0\0\1"
_H264_SLICES, _H264_IDR, _H264_PARAMETERS = range(1, 6), 5, (7, 8, 13)
_H265_SLICES, _H265_KEYS, _H265_PARAMETERS = range(32), range(16, 24), (32, 33, 34)
_H264_SPS, _H265_SPS = 7, 33


class Unit(NamedTuple):
    """One unit, without its start code."""

    kind: int
    data: bytes


class Head(NamedTuple):
    """What stands in a packet before and in its first slice."""

    key: bool
    """Whether decoding can begin with it, given the parameter sets."""
    parameters: bytes
    """Its parameter sets with their start codes; empty where it has none."""
    slice_: bytes
    """Its first slice; empty where it has none."""
    sps: bytes
    """Its sequence parameter set; empty where it has none."""


def with_start_codes(data: bytes) -> bytes:
    """A packet whose units are told apart by start codes, also where each had its length in front."""
    if data.startswith((_START, b"\0" + _START)):
        return data
    units, offset = [], 0
    while offset + 4 <= len(data):
        size = int.from_bytes(data[offset : offset + 4])
        if not size or offset + 4 + size > len(data):
            return data
        units.append(data[offset + 4 : offset + 4 + size])
        offset += 4 + size
    return b"".join(b"\0" + _START + unit for unit in units) if units and offset == len(data) else data


def head_of_packet(data: bytes, *, h265: bool) -> Head:
    """What a packet begins with, up to its first slice."""
    slices = _H265_SLICES if h265 else _H264_SLICES
    parameters: list[bytes] = []
    sps = b""
    for kind, unit in units_of(data, h265=h265):
        if kind in (_H265_PARAMETERS if h265 else _H264_PARAMETERS):
            parameters.append(b"\0" + _START + unit)
            sps = unit if kind == (_H265_SPS if h265 else _H264_SPS) else sps
        elif kind in slices:
            key = kind in _H265_KEYS if h265 else kind == _H264_IDR
            return Head(key or bool(sps), b"".join(parameters), unit, sps)
    return Head(key=False, parameters=b"".join(parameters), slice_=b"", sps=sps)


def units_of(data: bytes, *, h265: bool) -> Iterator[Unit]:
    """The units of a packet, in their order."""
    start = data.find(_START)
    while start != -1:
        start += len(_START)
        end = data.find(_START, start)
        unit = data[start : len(data) if end == -1 else end]
        if unit:
            yield Unit((unit[0] >> 1) & 0x3F if h265 else unit[0] & 0x1F, unit)
        start = end
