"""ROS messages of the demo robot, serialised for ROS 1 or ROS 2."""

import json
from collections.abc import Callable
from typing import Any

import cv2
import numpy as np
from jaxtyping import Float, UInt8
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from navtool.pipeline.arrays import Array
from navtool.pipeline.geometry.camera import CameraModel
from navtool.pipeline.geometry.transforms import quaternion_from_rpy
from navtool.sim.lidar import Scan
from navtool.sim.rig import MOUNTS, WHEELS
from navtool.sim.track import Failure

_POINT = np.dtype(
    {
        "names": ["x", "y", "z", "intensity", "ring", "time"],
        "formats": ["<f4", "<f4", "<f4", "<f4", "<u2", "<f4"],
        "offsets": [0, 4, 8, 12, 16, 18],
        "itemsize": 22,
    }
)
"""The layout of the Velodyne driver's clouds."""
_POINT_FIELD_TYPES = {"<f4": 7, "<u2": 4}
_TRANSFORMS = "geometry_msgs/TransformStamped[] transforms"


class MessageFactory:
    """Builds and serialises messages; every method returns the bytes as a recorder stores them."""

    def __init__(self, *, ros1: bool) -> None:
        self.ros1 = ros1
        self.store: Typestore = get_typestore(Stores.ROS1_NOETIC if ros1 else Stores.ROS2_HUMBLE)
        if "tf2_msgs/msg/TFMessage" not in self.store.types:
            self.store.register(get_types_from_msg(_TRANSFORMS, "tf2_msgs/msg/TFMessage"))

    def image(self, stamp_ns: int, rgb: UInt8[Array, "h w 3"], quality: int) -> bytes:
        """A sensor_msgs/CompressedImage with a JPEG."""
        _, jpeg = cv2.imencode(".jpg", rgb[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, quality])
        header = self._header(stamp_ns, "camera_front_optical")
        return self._bytes("sensor_msgs/msg/CompressedImage", header=header, format="jpeg", data=jpeg.reshape(-1))

    def camera_info(self, stamp_ns: int, camera: CameraModel) -> bytes:
        """A sensor_msgs/CameraInfo."""
        matrix = camera.matrix()
        arrays = {
            "d": np.array(camera.distortion),
            "k": matrix.reshape(9),
            "r": np.eye(3).reshape(9),
            "p": np.concatenate([matrix, np.zeros((3, 1))], axis=1).reshape(12),
        }
        whole = {"x_offset": 0, "y_offset": 0, "height": 0, "width": 0, "do_rectify": False}
        return self._bytes(
            "sensor_msgs/msg/CameraInfo",
            header=self._header(stamp_ns, "camera_front_optical"),
            height=camera.height,
            width=camera.width,
            distortion_model=camera.distortion_model,
            binning_x=0,
            binning_y=0,
            roi=self._make("sensor_msgs/msg/RegionOfInterest", **whole),
            **{name.upper() if self.ros1 else name: array for name, array in arrays.items()},
        )

    def cloud(self, stamp_ns: int, scan: Scan) -> bytes:
        """A sensor_msgs/PointCloud2 as the Velodyne driver publishes it, points without a return left out."""
        points = np.empty(scan.ring.size, _POINT)
        for axis, name in enumerate("xyz"):
            points[name] = scan.xyz[:, axis]
        points["intensity"], points["ring"], points["time"] = scan.intensity, scan.ring, scan.time_s
        fields = [
            self._make(
                "sensor_msgs/msg/PointField",
                name=name,
                offset=int(_POINT.fields[name][1]) if _POINT.fields else 0,
                datatype=_POINT_FIELD_TYPES[_POINT[name].str],
                count=1,
            )
            for name in _POINT.names or ()
        ]
        return self._bytes(
            "sensor_msgs/msg/PointCloud2",
            header=self._header(stamp_ns, "velodyne"),
            height=1,
            width=points.size,
            fields=fields,
            is_bigendian=False,
            point_step=_POINT.itemsize,
            row_step=_POINT.itemsize * points.size,
            data=points.view(np.uint8).reshape(-1),
            is_dense=True,
        )

    def odometry(self, stamp_ns: int, sample: Float[Array, "5"]) -> bytes:
        """A nav_msgs/Odometry of base_link in odom; the sample is x, y, yaw, speed, turn."""
        x, y, yaw, speed, turn = sample.tolist()
        pose = self._make(
            "geometry_msgs/msg/Pose", position=self._point(x, y, 0.0), orientation=self._quaternion((0.0, 0.0, yaw))
        )
        covariance = np.diag([1e-3, 1e-3, 1e6, 1e6, 1e6, 1e-2]).reshape(36)
        twist = self._twist(speed, turn)
        return self._bytes(
            "nav_msgs/msg/Odometry",
            header=self._header(stamp_ns, "odom"),
            child_frame_id="base_link",
            pose=self._make("geometry_msgs/msg/PoseWithCovariance", pose=pose, covariance=covariance),
            twist=self._make("geometry_msgs/msg/TwistWithCovariance", twist=twist, covariance=covariance),
        )

    def imu(self, stamp_ns: int, sample: Float[Array, "6"]) -> bytes:
        """A sensor_msgs/Imu without orientation (covariance -1); the sample is specific force, then turn rates."""
        ax, ay, az, wx, wy, wz = sample.tolist()
        unknown = np.zeros(9)
        unknown[0] = -1.0
        return self._bytes(
            "sensor_msgs/msg/Imu",
            header=self._header(stamp_ns, "imu_link"),
            orientation=self._quaternion((0.0, 0.0, 0.0)),
            orientation_covariance=unknown,
            angular_velocity=self._vector(wx, wy, wz),
            angular_velocity_covariance=np.diag([1e-4] * 3).reshape(9),
            linear_acceleration=self._vector(ax, ay, az),
            linear_acceleration_covariance=np.diag([1e-2] * 3).reshape(9),
        )

    def joints(self, stamp_ns: int, sample: Float[Array, "3 4"]) -> bytes:
        """A sensor_msgs/JointState of the four wheels; the rows are position, velocity, effort."""
        names = dict(zip(("position", "velocity", "effort"), np.ascontiguousarray(sample), strict=True))
        return self._bytes("sensor_msgs/msg/JointState", header=self._header(stamp_ns, ""), name=list(WHEELS), **names)

    def battery(self, stamp_ns: int, sample: Float[Array, "2"]) -> bytes:
        """A sensor_msgs/BatteryState; the sample is current (A, negative while discharging) and voltage (V)."""
        current, voltage = sample.tolist()
        unknown = float("nan")
        return self._bytes(
            "sensor_msgs/msg/BatteryState",
            header=self._header(stamp_ns, "base_link"),
            voltage=voltage,
            temperature=31.0,
            current=current,
            charge=unknown,
            capacity=unknown,
            design_capacity=20.0,
            percentage=0.8,
            power_supply_status=2,
            power_supply_health=1,
            power_supply_technology=3,
            present=True,
            cell_voltage=np.zeros(0, np.float32),
            cell_temperature=np.zeros(0, np.float32),
            location="",
            serial_number="",
        )

    def command(self, stamp_ns: int, speed_mps: float, turn_radps: float) -> bytes:
        """A geometry_msgs/TwistStamped in base_link."""
        header = self._header(stamp_ns, "base_link")
        return self._bytes("geometry_msgs/msg/TwistStamped", header=header, twist=self._twist(speed_mps, turn_radps))

    def intervention(self, *, active: bool) -> bytes:
        """A std_msgs/Bool."""
        return self._bytes("std_msgs/msg/Bool", data=active)

    def event(self, start_ns: int, failure: Failure) -> bytes:
        """A std_msgs/String with a failure as JSON: start_ns, end_ns, outcome (0), reason."""
        first, last = (start_ns + round(moment * 1e9) for moment in (failure.start_s, failure.end_s))
        text = json.dumps({"start_ns": first, "end_ns": last, "outcome": 0, "reason": failure.reason})
        return self._bytes("std_msgs/msg/String", data=text)

    def static_transforms(self, stamp_ns: int) -> bytes:
        """A tf2_msgs/TFMessage with the robot's mounts."""
        transforms = []
        for (parent, child), (x, y, z, *rpy) in MOUNTS.items():
            rotation = self._quaternion((rpy[0], rpy[1], rpy[2]))
            pose = self._make("geometry_msgs/msg/Transform", translation=self._vector(x, y, z), rotation=rotation)
            header = self._header(stamp_ns, parent)
            named = {"header": header, "child_frame_id": child, "transform": pose}
            transforms.append(self._make("geometry_msgs/msg/TransformStamped", **named))
        return self._bytes("tf2_msgs/msg/TFMessage", transforms=transforms)

    def _make(self, type_name: str, **values: object) -> Any:
        make: Callable[..., Any] = self.store.types[type_name]
        return make(**values)

    def _bytes(self, type_name: str, **values: object) -> bytes:
        message = self._make(type_name, **values)
        serialize = self.store.serialize_ros1 if self.ros1 else self.store.serialize_cdr
        return bytes(serialize(message, type_name))

    def _header(self, stamp_ns: int, frame: str) -> object:
        seconds, nanoseconds = divmod(stamp_ns, 10**9)
        stamp = self._make("builtin_interfaces/msg/Time", sec=seconds, nanosec=nanoseconds)
        sequence = {"seq": 0} if self.ros1 else {}
        return self._make("std_msgs/msg/Header", **sequence, stamp=stamp, frame_id=frame)

    def _vector(self, x: float, y: float, z: float) -> object:
        return self._make("geometry_msgs/msg/Vector3", x=x, y=y, z=z)

    def _point(self, x: float, y: float, z: float) -> object:
        return self._make("geometry_msgs/msg/Point", x=x, y=y, z=z)

    def _quaternion(self, rpy: tuple[float, float, float]) -> object:
        x, y, z, w = quaternion_from_rpy(np.array(rpy)).tolist()
        return self._make("geometry_msgs/msg/Quaternion", x=x, y=y, z=z, w=w)

    def _twist(self, speed_mps: float, turn_radps: float) -> object:
        linear, angular = self._vector(speed_mps, 0.0, 0.0), self._vector(0.0, 0.0, turn_radps)
        return self._make("geometry_msgs/msg/Twist", linear=linear, angular=angular)
