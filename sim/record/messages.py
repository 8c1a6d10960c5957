"""ROS messages of a robot, serialised for ROS 1 or ROS 2."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import cv2
import numpy as np
from jaxtyping import Float, UInt8, UInt16
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from navtool.pipeline.arrays import Array
from navtool.pipeline.geometry.camera import CameraModel
from navtool.pipeline.geometry.transforms import quaternion_from_rpy
from navtool.sim.record.rig import BASE, CAMERA, IMU, LIDAR, ODOM, Pose
from navtool.sim.sensors.lidar import Cloud

_POINT = np.dtype(
    {
        "names": ["x", "y", "z", "intensity", "ring", "time"],
        "formats": ["<f4", "<f4", "<f4", "<f4", "<u2", "<f4"],
        "offsets": [0, 4, 8, 12, 16, 18],
        "itemsize": 22,
    }
)
"""The layout of the Velodyne driver's clouds."""
_FIELDS = (("x", 0, 7), ("y", 4, 7), ("z", 8, 7), ("intensity", 12, 7), ("ring", 16, 4), ("time", 18, 7))
"""Name, offset and PointField's number of the type."""
_TRANSFORMS = "geometry_msgs/TransformStamped[] transforms"
_TF = "tf2_msgs/msg/TFMessage"
_ODOMETRY_VARIANCE = (1e-3, 1e-3, 1e6, 1e6, 1e6, 1e-2)


class MessageFactory:
    """Builds and serialises messages; every method returns the bytes as a recorder stores them."""

    def __init__(self, *, ros1: bool) -> None:
        self.ros1 = ros1
        self.store: Typestore = get_typestore(Stores.ROS1_NOETIC if ros1 else Stores.ROS2_HUMBLE)
        if _TF not in self.store.types:
            self.store.register(get_types_from_msg(_TRANSFORMS, _TF))

    def jpeg(self, stamp_ns: int, rgb: UInt8[Array, "h w 3"], quality: int) -> bytes:
        """A sensor_msgs/CompressedImage of the front camera."""
        _, jpeg = cv2.imencode(".jpg", rgb[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, quality])
        header = self._header(stamp_ns, CAMERA)
        return self._bytes("sensor_msgs/msg/CompressedImage", header=header, format="jpeg", data=jpeg.reshape(-1))

    def raw_image(self, stamp_ns: int, pixels: UInt8[Array, "h w"] | UInt16[Array, "h w"]) -> bytes:
        """A sensor_msgs/Image of the front camera's pixels, mono8 or 16UC1."""
        height, width = pixels.shape
        data = np.ascontiguousarray(pixels).view(np.uint8).reshape(-1)
        return self._bytes(
            "sensor_msgs/msg/Image",
            header=self._header(stamp_ns, CAMERA),
            height=height,
            width=width,
            encoding="mono8" if pixels.itemsize == 1 else "16UC1",
            is_bigendian=0,
            step=width * pixels.itemsize,
            data=data,
        )

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
            header=self._header(stamp_ns, CAMERA),
            height=camera.height,
            width=camera.width,
            distortion_model=camera.distortion_model,
            binning_x=0,
            binning_y=0,
            roi=self._make("sensor_msgs/msg/RegionOfInterest", **whole),
            **{name.upper() if self.ros1 else name: array for name, array in arrays.items()},
        )

    def cloud(self, stamp_ns: int, cloud: Cloud) -> bytes:
        """A sensor_msgs/PointCloud2 as the Velodyne driver publishes it, points without a return left out."""
        points = np.empty(cloud.ring.size, _POINT)
        for axis, name in enumerate("xyz"):
            points[name] = cloud.xyz[:, axis]
        points["intensity"], points["ring"], points["time"] = cloud.intensity, cloud.ring, cloud.time_s
        fields = [
            self._make("sensor_msgs/msg/PointField", name=name, offset=offset, datatype=kind, count=1)
            for name, offset, kind in _FIELDS
        ]
        return self._bytes(
            "sensor_msgs/msg/PointCloud2",
            header=self._header(stamp_ns, LIDAR),
            height=1,
            width=points.size,
            fields=fields,
            is_bigendian=False,
            point_step=_POINT.itemsize,
            row_step=_POINT.itemsize * points.size,
            data=points.view(np.uint8).reshape(-1),
            is_dense=True,
        )

    def odometry(
        self,
        stamp_ns: int,
        frame: str,
        position_m: Float[Array, "3"],
        quaternion: Float[Array, "4"],
        velocity: Float[Array, "6"],
        variance: Sequence[float] = _ODOMETRY_VARIANCE,
    ) -> bytes:
        """A nav_msgs/Odometry of base_link.

        Args:
            stamp_ns: Of the header.
            frame: In which the pose is.
            position_m: Of base_link.
            quaternion: x, y, z, w.
            velocity: Linear in m/s, angular in rad/s, in base_link's axes.
            variance: Of x, y, z, roll, pitch, yaw.
        """
        x, y, z = position_m.tolist()
        pose = self._make(
            "geometry_msgs/msg/Pose",
            position=self._make("geometry_msgs/msg/Point", x=x, y=y, z=z),
            orientation=self._quaternion(quaternion),
        )
        covariance = np.diag(variance).astype(np.float64).reshape(36)
        twist = self._twist(velocity)
        return self._bytes(
            "nav_msgs/msg/Odometry",
            header=self._header(stamp_ns, frame),
            child_frame_id=BASE,
            pose=self._make("geometry_msgs/msg/PoseWithCovariance", pose=pose, covariance=covariance),
            twist=self._make("geometry_msgs/msg/TwistWithCovariance", twist=twist, covariance=covariance),
        )

    def imu(self, stamp_ns: int, sample: Float[Array, "6"]) -> bytes:
        """A sensor_msgs/Imu without orientation (covariance -1); the sample is specific force, then turn rates."""
        unknown = np.zeros(9)
        unknown[0] = -1.0
        return self._bytes(
            "sensor_msgs/msg/Imu",
            header=self._header(stamp_ns, IMU),
            orientation=self._quaternion(np.array([0.0, 0.0, 0.0, 1.0])),
            orientation_covariance=unknown,
            angular_velocity=self._vector(sample[3:]),
            angular_velocity_covariance=np.diag([1e-4] * 3).reshape(9),
            linear_acceleration=self._vector(sample[:3]),
            linear_acceleration_covariance=np.diag([1e-2] * 3).reshape(9),
        )

    def joints(self, stamp_ns: int, names: Sequence[str], sample: Float[Array, "3 j"]) -> bytes:
        """A sensor_msgs/JointState; the rows are position, velocity, effort."""
        rows = dict(zip(("position", "velocity", "effort"), np.ascontiguousarray(sample), strict=True))
        return self._bytes("sensor_msgs/msg/JointState", header=self._header(stamp_ns, ""), name=list(names), **rows)

    def battery(self, stamp_ns: int, sample: Float[Array, "2"]) -> bytes:
        """A sensor_msgs/BatteryState; the sample is current (A, negative while discharging) and voltage (V)."""
        current, voltage = sample.tolist()
        unknown = float("nan")
        return self._bytes(
            "sensor_msgs/msg/BatteryState",
            header=self._header(stamp_ns, BASE),
            voltage=voltage,
            temperature=unknown,
            current=current,
            charge=unknown,
            capacity=unknown,
            design_capacity=unknown,
            percentage=unknown,
            power_supply_status=2,
            power_supply_health=1,
            power_supply_technology=3,
            present=True,
            cell_voltage=np.zeros(0, np.float32),
            cell_temperature=np.zeros(0, np.float32),
            location="",
            serial_number="",
        )

    def command(self, stamp_ns: int, command: Float[Array, "2"]) -> bytes:
        """A geometry_msgs/TwistStamped in base_link; the command is speed and turn."""
        velocity = np.array([command[0], 0.0, 0.0, 0.0, 0.0, command[1]])
        header = self._header(stamp_ns, BASE)
        return self._bytes("geometry_msgs/msg/TwistStamped", header=header, twist=self._twist(velocity))

    def flag(self, *, active: bool) -> bytes:
        """A std_msgs/Bool."""
        return self._bytes("std_msgs/msg/Bool", data=active)

    def text(self, content: str) -> bytes:
        """A std_msgs/String."""
        return self._bytes("std_msgs/msg/String", data=content)

    def mounts(self, stamp_ns: int, poses: Mapping[tuple[str, str], Pose]) -> bytes:
        """A tf2_msgs/TFMessage with fixed frames: (parent, child) to the child's pose."""
        stamped = []
        for (parent, child), pose in poses.items():
            values = np.array(pose)
            stamped.append(self._transform(stamp_ns, parent, child, values[:3], quaternion_from_rpy(values[3:])))
        return self._bytes(_TF, transforms=stamped)

    def transform(self, stamp_ns: int, position_m: Float[Array, "3"], quaternion: Float[Array, "4"]) -> bytes:
        """A tf2_msgs/TFMessage with base_link in odom."""
        return self._bytes(_TF, transforms=[self._transform(stamp_ns, ODOM, BASE, position_m, quaternion)])

    def _transform(self, stamp_ns: int, parent: str, child: str, xyz: Array, quaternion: Array) -> object:
        rotation = self._quaternion(quaternion)
        return self._make(
            "geometry_msgs/msg/TransformStamped",
            header=self._header(stamp_ns, parent),
            child_frame_id=child,
            transform=self._make("geometry_msgs/msg/Transform", translation=self._vector(xyz), rotation=rotation),
        )

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

    def _vector(self, xyz: Float[Array, "3"]) -> object:
        x, y, z = xyz.tolist()
        return self._make("geometry_msgs/msg/Vector3", x=x, y=y, z=z)

    def _quaternion(self, quaternion: Float[Array, "4"]) -> object:
        x, y, z, w = quaternion.tolist()
        return self._make("geometry_msgs/msg/Quaternion", x=x, y=y, z=z, w=w)

    def _twist(self, velocity: Float[Array, "6"]) -> object:
        linear, angular = self._vector(velocity[:3]), self._vector(velocity[3:])
        return self._make("geometry_msgs/msg/Twist", linear=linear, angular=angular)
