"""The messages of the presets' robots as fields: layouts of clouds, vendors' states, and what stands in for others."""

from collections.abc import Callable, Mapping
from typing import Any

import cv2
import numpy as np

type Make = Callable[[dict[str, Any], float], dict[str, Any]]
"""A message's fields from its header and the seconds since the drive began."""

SPEED_MPS = 0.7
TURN_RADPS = -0.2
DRAWN_A = 4.0
ANYMAL_JOINTS = tuple(f"{leg}_{joint}" for leg in ("LF", "RF", "LH", "RH") for joint in ("HAA", "HFE", "KFE"))
SWEEP_S = 0.1
POINTS = 600
_KINDS = {"u1": 2, "u2": 4, "u4": 6, "f4": 7, "f8": 8}


def cloud(header: Mapping[str, Any], columns: Mapping[str, tuple[str, Any]], *, step: int = 0) -> dict[str, Any]:
    """PointCloud2 of 600 points with x, y, z and other columns (name: type, values), in the order given."""
    angle = np.linspace(-np.pi, np.pi, POINTS, endpoint=False)
    xyz = {"x": ("f4", 8 * np.cos(angle)), "y": ("f4", 8 * np.sin(angle)), "z": ("f4", np.linspace(-0.5, 1, POINTS))}
    table = np.zeros(POINTS, dtype=[(name, f"<{kind}") for name, (kind, _) in (xyz | dict(columns)).items()])
    for name, (_, values) in (xyz | dict(columns)).items():
        table[name] = values
    described: Any = table.dtype.fields
    size = max(step, table.dtype.itemsize)
    data = np.zeros((POINTS, size), np.uint8)
    data[:, : table.dtype.itemsize] = table.view(np.uint8).reshape(POINTS, -1)
    fields = [
        {"name": name, "offset": offset, "datatype": _KINDS[kind.str.lstrip("<|")], "count": 1}
        for name, (kind, offset, *_) in described.items()
    ]
    shape = {"height": 1, "width": POINTS, "point_step": size, "row_step": size * POINTS, "is_dense": True}
    return {**header, **shape, "fields": fields, "data": data.ravel()}


def _share() -> Any:
    """How far into the sweep each point was measured, 0 to 1."""
    return np.arange(POINTS) / POINTS


def _absolute_s(header: Mapping[str, Any]) -> float:
    stamp = header["header"]["stamp"]
    return float(stamp["sec"] + stamp["nanosec"] * 1e-9)


def ouster_of_2020(header: dict[str, Any], _: float) -> dict[str, Any]:
    """Ring in a byte, ``noise`` where later drivers have ``ambient``, nanoseconds from the header, padded points."""
    columns = {
        "intensity": ("f4", 50.0),
        "t": ("u4", np.rint(_share() * SWEEP_S * 1e9)),
        "reflectivity": ("u2", 7),
        "ring": ("u1", np.arange(POINTS) % 64),
        "noise": ("u2", 3),
        "range": ("u4", 8000),
    }
    return cloud(header, columns, step=48)


def ouster(header: dict[str, Any], _: float) -> dict[str, Any]:
    columns = {
        "intensity": ("f4", 50.0),
        "t": ("u4", np.rint(_share() * SWEEP_S * 1e9)),
        "reflectivity": ("u2", 7),
        "ring": ("u2", np.arange(POINTS) % 128),
        "ambient": ("u2", 3),
        "range": ("u4", 8000),
    }
    return cloud(header, columns, step=48)


def velodyne_stamped_at_the_end(header: dict[str, Any], _: float) -> dict[str, Any]:
    columns = {
        "intensity": ("f4", 50.0),
        "ring": ("u2", np.arange(POINTS) % 32),
        "time": ("f4", (_share() - 1) * SWEEP_S),
    }
    return cloud(header, columns)


def hesai(header: dict[str, Any], _: float) -> dict[str, Any]:
    columns = {
        "intensity": ("f4", 50.0),
        "timestamp": ("f8", _absolute_s(header) + _share() * SWEEP_S),
        "ring": ("u2", np.arange(POINTS) % 32),
    }
    return cloud(header, columns)


def livox(header: dict[str, Any], _: float) -> dict[str, Any]:
    columns = {
        "intensity": ("f4", 50.0),
        "tag": ("u1", 16),
        "line": ("u1", np.arange(POINTS) % 4),
        "timestamp": ("f8", (_absolute_s(header) + _share() * SWEEP_S) * 1e9),
    }
    return cloud(header, columns)


def xyz_alone(header: dict[str, Any], _: float) -> dict[str, Any]:
    return cloud(header, {})


def _joy(header: dict[str, Any], _: float) -> dict[str, Any]:
    return {**header, "axes": np.array([0.5, 0.0, 0.0, 0.01, -0.5, 0.0]), "buttons": np.zeros(4, np.int32)}


def _odometry(header: dict[str, Any], _: float) -> dict[str, Any]:
    twist = {"linear": {"x": SPEED_MPS}, "angular": {"z": TURN_RADPS}}
    return {**header, "child_frame_id": "base", "twist": {"twist": twist}}


def _looks_to_the_right(header: dict[str, Any], time_s: float) -> dict[str, Any]:
    """Straight on along y of the odometry frame, with a yaw of 0."""
    pose = {"position": {"x": 5.0, "y": SPEED_MPS * time_s, "z": 0.0}, "orientation": {"w": 1.0}}
    twist = {"linear": {"x": SPEED_MPS}, "angular": {"z": 0.0}}
    return {**header, "child_frame_id": "vehicle", "pose": {"pose": pose}, "twist": {"twist": twist}}


def _stamped_twist(header: dict[str, Any], _: float) -> dict[str, Any]:
    return {**header, "twist": {"linear": {"x": SPEED_MPS}, "angular": {"z": TURN_RADPS}}}


def _mosaic(header: dict[str, Any], _: float) -> dict[str, Any]:
    pixels = np.zeros((96, 128), np.uint8)
    pixels[0::2, 0::2] = 200  # the red ones of rggb
    return {**header, "width": 128, "height": 96, "step": 128, "encoding": "bayer_rggb8", "data": pixels.ravel()}


def _jpeg_called_rgb8(header: dict[str, Any], _: float) -> dict[str, Any]:
    red = np.zeros((96, 128, 3), np.uint8)
    red[..., 2] = 200
    jpeg = cv2.imencode(".jpg", red)[1].ravel()
    return {**header, "width": 128, "height": 96, "step": 384, "encoding": "rgb8", "data": jpeg}


def spot_joints(legs: list[str]) -> dict[str, Any]:
    """An arm's joint first, those of the legs backwards; the value of each of these is its place among the legs."""
    values = np.array([99.0, *reversed(range(len(legs)))])
    return {"name": ["arm0.sh0", *reversed(legs)], **dict.fromkeys(("position", "velocity", "effort"), values)}


def _batteries(header: dict[str, Any], _: float) -> dict[str, Any]:
    one = {**header, "current": -2.5, "voltage": 57.0, "charge_percentage": 80.0}
    return {"battery_states": [one, one | {"current": -1.5}]}


def _husky(header: dict[str, Any], time_s: float) -> dict[str, Any]:
    drawn = {"left_driver_current": 1.5, "right_driver_current": 1.0, "mcu_and_user_port_current": 1.5}
    return {**header, **drawn, "e_stop": time_s >= 1.0}


def _warthog(header: dict[str, Any], time_s: float) -> dict[str, Any]:
    return {**header, "current_battery": DRAWN_A, "current_48v": 1.0, "stop_engaged": time_s >= 1.0}


def _jackal(header: dict[str, Any], _: float) -> dict[str, Any]:
    return {**header, "total_current": DRAWN_A}


def _power(header: dict[str, Any], _: float) -> dict[str, Any]:
    return {**header, "measured_currents": [1.0, 1.5, 1.5], "measured_voltages": [25.0, 24.0, 24.0]}


def _pedals(_: dict[str, Any], time_s: float) -> dict[str, Any]:
    return {"throttle": 20.0, "brake": 350.0 if time_s >= 1.0 else 0.0}


def _anymal_joints(header: dict[str, Any], _: float) -> dict[str, Any]:
    values = dict.fromkeys(("position", "velocity", "effort"), np.arange(12.0))
    return {**header, "joints": {**header, "name": list(ANYMAL_JOINTS), **values}}


def _anymal_battery(header: dict[str, Any], _: float) -> dict[str, Any]:
    return {**header, "current": DRAWN_A, "voltage": 51.0, "state_of_charge": 0.8, "status": 2}


def _unitree(imu: str, motor: str, torque: str, bms: dict[str, Any]) -> Make:
    def make(_: dict[str, Any], __: float) -> dict[str, Any]:
        motors = [{"q": n, "dq": 2 * n, torque: 3 * n} for n in range(20)]
        attitude = {"quaternion": [1, 0, 0, 0], "gyroscope": [0, 0, 0.5], "accelerometer": [0, 0, 9.81]}
        return {imu: attitude, motor: motors, **bms}

    return make


_low_state = _unitree("imu_state", "motor_state", "tau_est", {"bms_state": {"current": -4000, "soc": 80}})
_high_state = _unitree("imu", "motorState", "tauEst", {"bms": {"current": -4000, "SOC": 80}})


def _sport(header: dict[str, Any], time_s: float) -> dict[str, Any]:
    stamp = header["header"]["stamp"]
    return {"stamp": stamp, "position": [SPEED_MPS * time_s, 0, 0.3], "imu_state": {"quaternion": [1, 0, 0, 0]}}


CLOUD, IMAGE, ODOMETRY = "sensor_msgs/msg/PointCloud2", "sensor_msgs/msg/Image", "nav_msgs/msg/Odometry"
TWIST_STAMPED, JOY = "geometry_msgs/msg/TwistStamped", "sensor_msgs/msg/Joy"
BATTERIES, WARTHOG = "spot_msgs/msg/BatteryStateArray", "warthog_msgs/msg/Status"
PEDALS = "racepak/msg/rp_controls"


def _scan(header: dict[str, Any], _: float) -> dict[str, Any]:
    limits = {"angle_min": -2.0, "angle_increment": 0.005, "range_min": 0.1, "range_max": 20.0}
    return {**header, **limits, "ranges": np.linspace(3.0, 6.0, 800)}


OTHER_TYPES: dict[tuple[str, str], tuple[str, Make]] = {
    ("turtlebot4", "lidar"): ("sensor_msgs/msg/LaserScan", _scan),
    ("paad", "lidar"): ("sensor_msgs/msg/LaserScan", _scan),
    ("rellis3d", "battery"): (WARTHOG, _warthog),
    ("rellis3d", "camera"): (IMAGE, _mosaic),
    ("rellis3d", "lidar"): (CLOUD, ouster_of_2020),
    ("warthog", "battery"): (WARTHOG, _warthog),
    ("spot_ros1", "camera"): (IMAGE, _jpeg_called_rgb8),
    ("spot_ros1", "lidar"): (CLOUD, xyz_alone),
    ("spot_ros1", "battery"): (BATTERIES, _batteries),
    ("spot_ros2", "camera"): (IMAGE, _jpeg_called_rgb8),
    ("spot_ros2", "battery"): (BATTERIES, _batteries),
    ("husky", "battery"): ("husky_msgs/msg/HuskyStatus", _husky),
    ("jackal", "battery"): ("jackal_msgs/msg/Status", _jackal),
    ("clearpath_ros2", "battery"): ("clearpath_platform_msgs/msg/Power", _power),
    ("anymal_grandtour", "joints"): ("anymal_msgs/msg/AnymalState", _anymal_joints),
    ("anymal_grandtour", "battery"): ("anymal_msgs/msg/BatteryState", _anymal_battery),
    ("anymal_grandtour", "lidar"): (CLOUD, hesai),
    ("anymal_grandtour", "command"): (TWIST_STAMPED, _stamped_twist),
    ("fusionportable_v2", "battery"): ("unitree_legged_msgs/msg/HighState", _high_state),
    ("fusionportable_v2", "lidar"): (CLOUD, ouster),
    ("unitree_ros2", "imu"): ("unitree_go/msg/LowState", _low_state),
    ("unitree_ros2", "odometry"): ("unitree_go/msg/SportModeState", _sport),
    ("m2dgr", "lidar"): (CLOUD, velodyne_stamped_at_the_end),
    ("musohu", "lidar"): (CLOUD, velodyne_stamped_at_the_end),
    ("musohu", "command"): (ODOMETRY, _odometry),
    ("scand_jackal", "command"): (JOY, _joy),
    ("scand_spot", "command"): (JOY, _joy),
    ("tartandrive1", "odometry"): (ODOMETRY, _looks_to_the_right),
    ("tartandrive1", "command"): (TWIST_STAMPED, _stamped_twist),
    ("tartandrive1", "intervention"): (PEDALS, _pedals),
    ("tartandrive2", "odometry"): (ODOMETRY, _looks_to_the_right),
    ("tartandrive2", "intervention"): (PEDALS, _pedals),
}
"""What the streams of a preset come in where it is not the usual type; one that feeds several stands for all."""
