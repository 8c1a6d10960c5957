"""A cloud in rows and columns, with any further fields."""

from typing import Any

import numpy as np

ROWS, COLUMNS = 8, 30
_KINDS = {"u2": 4, "f4": 7, "f8": 8, "i8": 9, "u8": 10, "?": 11}


def organised(stamp_ns: int, *more: tuple[str, str, Any], kind: str = "f4") -> dict[str, Any]:
    """The fields of a cloud of rows, a wall 3 m ahead."""
    count = ROWS * COLUMNS
    names = [("x", kind), ("y", kind), ("z", kind), *((name, code) for name, code, _ in more)]
    table = np.zeros(count, dtype=[(name, f"<{code}" if code != "?" else "?") for name, code in names])
    table["x"], table["y"], table["z"] = (
        3.0,
        np.tile(np.linspace(-2, 2, COLUMNS), ROWS),
        np.repeat(np.arange(ROWS) / 4, COLUMNS),
    )
    for name, _, values in more:
        table[name] = values
    step = table.dtype.itemsize
    described: Any = table.dtype.fields
    return {
        "header": {"stamp": {"sec": stamp_ns // 10**9, "nanosec": stamp_ns % 10**9}, "frame_id": "lidar"},
        "height": ROWS,
        "width": COLUMNS,
        "fields": [{"name": n, "offset": described[n][1], "datatype": _KINDS[code], "count": 1} for n, code in names],
        "point_step": step,
        "row_step": COLUMNS * step,
        "data": np.frombuffer(table.tobytes(), np.uint8),
        "is_dense": True,
    }
