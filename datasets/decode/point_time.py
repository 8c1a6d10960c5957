"""Times of the points of a cloud, whose fields say neither their unit nor their origin."""

import numpy as np
from jaxtyping import Float32, Shaped

from navtool.pipeline.arrays import Array

_ABSOLUTE_S = 1e9
_ABSOLUTE_NS = 1e15
_SAME_CLOCK_S = 10.0


def seconds_from_header(time: Shaped[Array, " n"], stamp_ns: int) -> Float32[Array, " n"]:
    """Seconds after the header's stamp, negative before it.

    Drivers differ, and the field's type decides: integers are nanoseconds from the header (Ouster, Autoware), 64-bit
    ones beyond 1e15 absolute; floats up to 1e9 are seconds from the header (Velodyne); doubles beyond are absolute, in
    seconds (Hesai) or, beyond 1e15, in nanoseconds (Livox).

    Args:
        time: Of any of the field types, in any byte order.
        stamp_ns: The header's stamp.

    Note:
        Where absolute times and the header differ by more than 10 s they are from different clocks (or the header was
        left unset): the times are then taken from the earliest point.
    """
    if time.dtype.kind in "iu" and time.dtype.itemsize == 8 and time.size and int(time.max()) > _ABSOLUTE_NS:
        # Absolute nanoseconds, which doubles do not hold.
        origin_ns = stamp_ns if abs(int(time.max()) - stamp_ns) <= _SAME_CLOCK_S * 1e9 else int(time.min())
        return ((time.astype(np.int64) - origin_ns) * 1e-9).astype(np.float32)
    if time.dtype.kind in "iu":
        return np.asarray(time.astype(np.float64) * 1e-9, np.float32)
    if time.dtype.itemsize < 8:
        return time.astype(np.float32)
    finite = time[np.isfinite(time)]
    largest = float(finite.max()) if finite.size else 0.0
    if largest <= _ABSOLUTE_S:
        return time.astype(np.float32)
    units_per_s = 1e9 if largest > _ABSOLUTE_NS else 1.0
    origin = stamp_ns * units_per_s / 1e9
    if abs(largest - origin) > _SAME_CLOCK_S * units_per_s:
        origin = float(finite.min())
    return ((time - origin) / units_per_s).astype(np.float32)


def seconds_from_base(offset_ns: Shaped[Array, " n"], base_ns: int, stamp_ns: int) -> Float32[Array, " n"]:
    """Seconds after the header's stamp of times that count from a base in the message (Livox).

    The drivers stamp the header with that base. Where somebody else stamped it, within 10 s both count as times of one
    clock; beyond, they are of different clocks (or one was left unset), and the header's stamp is taken for the base.

    Args:
        offset_ns: Unsigned nanoseconds from the base.
        base_ns: The base, in nanoseconds of the sensor's clock.
        stamp_ns: The header's stamp.
    """
    shift_ns = base_ns - stamp_ns
    if abs(shift_ns) > _SAME_CLOCK_S * 1e9:
        shift_ns = 0
    return ((offset_ns.astype(np.float64) + shift_ns) * 1e-9).astype(np.float32)
