"""The usual layouts of the messages that come hundreds of times a second.

Written out: reading the definitions of a whole ROS distribution for these four takes an eighth of a second.
"""

type Layout = tuple[object, ...]

_BASE, _ARRAY, _SEQUENCE = 0, 3, 4
_FLOAT, _TEXT, _U32 = ("float64", _BASE), ("string", _BASE), ("uint32", _BASE)
_STAMP = (("sec", ("int32", _BASE)), ("nanosec", _U32))
_VECTOR = (("x", _FLOAT), ("y", _FLOAT), ("z", _FLOAT))
_QUATERNION = (*_VECTOR, ("w", _FLOAT))
_TWIST = (("linear", _VECTOR), ("angular", _VECTOR))
_POSE = (("position", _VECTOR), ("orientation", _QUATERNION))


def usual_layout(name: str, encoding: str) -> Layout | None:
    """The fields of a message type as every ROS distribution defines it, the way `MessageType.layout` tells them.

    Args:
        encoding: ``ros1`` or ``cdr``: headers of ROS 1 are numbered.

    Returns:
        None for a type that is not among `USUAL`.
    """
    if name not in _BEHIND_HEADER:
        return None
    numbered = (("seq", _U32),) if encoding == "ros1" else ()
    return (("header", (*numbered, ("stamp", _STAMP), ("frame_id", _TEXT))), *_BEHIND_HEADER[name])


def _covariance(size: int) -> Layout:
    return (_ARRAY, _FLOAT, size)


def _list(kind: Layout) -> Layout:
    return (_SEQUENCE, kind, 0)


_BEHIND_HEADER: dict[str, Layout] = {
    "geometry_msgs/msg/TwistStamped": (("twist", _TWIST),),
    "nav_msgs/msg/Odometry": (
        ("child_frame_id", _TEXT),
        ("pose", (("pose", _POSE), ("covariance", _covariance(36)))),
        ("twist", (("twist", _TWIST), ("covariance", _covariance(36)))),
    ),
    "sensor_msgs/msg/Imu": (
        ("orientation", _QUATERNION),
        ("orientation_covariance", _covariance(9)),
        ("angular_velocity", _VECTOR),
        ("angular_velocity_covariance", _covariance(9)),
        ("linear_acceleration", _VECTOR),
        ("linear_acceleration_covariance", _covariance(9)),
    ),
    "sensor_msgs/msg/JointState": (
        ("name", _list(_TEXT)),
        ("position", _list(_FLOAT)),
        ("velocity", _list(_FLOAT)),
        ("effort", _list(_FLOAT)),
    ),
}
USUAL = tuple(_BEHIND_HEADER)
"""The types with a usual layout."""


def _transforms(header: Layout) -> Layout:
    moved = (("translation", _VECTOR), ("rotation", _QUATERNION))
    stamped = (("header", header), ("child_frame_id", _TEXT), ("transform", moved))
    return (("transforms", (_SEQUENCE, stamped, 0)),)


TRANSFORMS_LAYOUT = {
    "ros1": _transforms((("seq", _U32), ("stamp", _STAMP), ("frame_id", _TEXT))),
    "cdr": _transforms((("stamp", _STAMP), ("frame_id", _TEXT))),
}
"""The fields of a message of transforms, by encoding."""
