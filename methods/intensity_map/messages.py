"""Maps as messages of ROS 2: nav_msgs/OccupancyGrid, grid_map_msgs/GridMap and the transform that places them."""

from collections.abc import Callable, Iterator
from typing import Any, ClassVar, Final

import numpy as np
from jaxtyping import Float32, Int8
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from navtool.methods.along.mcap_file import Message
from navtool.methods.along.writers import Outcome
from navtool.methods.intensity_map.mapped import LAYER_NAMES, MappedSweep
from navtool.pipeline.arrays import Array
from navtool.pipeline.geometry.transforms import quaternion_from_rpy
from navtool.pipeline.intensity_map.obstacles import CellClass

ODOM_FRAME, MAP_FRAME = "odom", "intensity_map"
"""The odometry's frame, and the sensor's place in it with the axes of the robot's base."""
TOPICS: Final = {
    "/intensity_map/classes": "nav_msgs/msg/OccupancyGrid",
    "/intensity_map/plan": "nav_msgs/msg/OccupancyGrid",
    "/intensity_map/layers": "grid_map_msgs/msg/GridMap",
    "/intensity_map/picture": "sensor_msgs/msg/CompressedImage",
    "/tf": "tf2_msgs/msg/TFMessage",
}
"""Every topic with its type."""
CLASS_OCCUPANCY: Final = {
    CellClass.free: 0,
    CellClass.pliable: 30,
    CellClass.transparent: 90,
    CellClass.solid: 100,
}
"""The occupancy of each class: what has to be avoided is above 65, which planners take for occupied by default."""
_GRID_MAP_INFO = """
float64 resolution
float64 length_x
float64 length_y
geometry_msgs/Pose pose
"""
_GRID_MAP = """
std_msgs/Header header
GridMapInfo info
string[] layers
string[] basic_layers
std_msgs/Float32MultiArray[] data
uint16 outer_start_index
uint16 inner_start_index
"""


class MapMessages:
    """Builds and serialises a map's messages; those that return bytes give them as a recorder stores them."""

    topics: ClassVar[dict[str, str]] = TOPICS

    def __init__(self, picture_of: Callable[[Outcome[MappedSweep]], bytes | None]) -> None:
        """Prepare it.

        Args:
            picture_of: The picture of a map as PNG; None where it has none.
        """
        self._picture_of = picture_of
        self._store = get_typestore(Stores.ROS2_HUMBLE)
        for name, definition in (("GridMapInfo", _GRID_MAP_INFO), ("GridMap", _GRID_MAP)):
            self._store.register(get_types_from_msg(definition, f"grid_map_msgs/msg/{name}"))

    def definition(self, type_name: str) -> str:
        """The type's definition with all that it refers to, as an MCAP's schema holds it."""
        text, _ = self._store.generate_msgdef(type_name, ros_version=2)
        return text

    def of(self, outcome: Outcome[MappedSweep]) -> Iterator[Message]:
        """A map's messages, the transform first; the picture where there is one."""
        mapped = outcome.result
        transform = self.transform(mapped)
        if transform is not None:
            yield Message("/tf", transform)
        yield Message("/intensity_map/classes", self.classes(mapped))
        yield Message("/intensity_map/plan", self.plan(mapped))
        yield Message("/intensity_map/layers", self.layers(mapped))
        png = self._picture_of(outcome)
        if png is not None:
            yield Message("/intensity_map/picture", self.picture(mapped, png))

    def classes(self, mapped: MappedSweep) -> bytes:
        """The classes as occupancies."""
        values = np.array([CLASS_OCCUPANCY[cell] for cell in sorted(CellClass)], np.int8)
        return self._occupancy(mapped, values[mapped.classes])

    def plan(self, mapped: MappedSweep) -> bytes:
        """The planning map: 100 is R and above."""
        percent = np.round(np.minimum(mapped.map.plan, 1) * np.float32(100))
        return self._occupancy(mapped, percent.astype(np.int8))

    def layers(self, mapped: MappedSweep) -> bytes:
        """All layers, the classes and the planning map. A layer is NaN where it has no point."""
        grid = mapped.config.grid
        there = mapped.map.layers.points > 0
        found = {
            name: np.where(points, value, np.float32(np.nan))
            for name, value, points in zip(LAYER_NAMES, mapped.values, there, strict=True)
        }
        found |= {"classes": mapped.classes.astype(np.float32), "plan": mapped.map.plan}
        info = self._make(
            "grid_map_msgs/msg/GridMapInfo",
            resolution=grid.cell_m,
            length_x=2 * grid.half_m,
            length_y=2 * grid.half_m,
            pose=self._pose(0.0, 0.0),
        )
        return self._bytes(
            "grid_map_msgs/msg/GridMap",
            header=self._header(mapped, MAP_FRAME),
            info=info,
            layers=list(found),
            basic_layers=[],
            data=[self._matrix(values) for values in found.values()],
            outer_start_index=0,
            inner_start_index=0,
        )

    def picture(self, mapped: MappedSweep, png: bytes) -> bytes:
        """The picture of a map."""
        data = np.frombuffer(png, np.uint8)
        header = self._header(mapped, MAP_FRAME)
        return self._bytes("sensor_msgs/msg/CompressedImage", header=header, format="png", data=data)

    def transform(self, mapped: MappedSweep) -> bytes | None:
        """Where the map is in the odometry frame, on its ground plane; None where that is not known."""
        if mapped.sweep.odom_sensor is None:
            return None
        x, y, yaw = mapped.sweep.odom_sensor.tolist()
        stamped = self._make(
            "geometry_msgs/msg/TransformStamped",
            header=self._header(mapped, ODOM_FRAME),
            child_frame_id=MAP_FRAME,
            transform=self._make(
                "geometry_msgs/msg/Transform",
                translation=self._make("geometry_msgs/msg/Vector3", x=x, y=y, z=0.0),
                rotation=self._quaternion(yaw),
            ),
        )
        return self._bytes("tf2_msgs/msg/TFMessage", transforms=[stamped])

    def _occupancy(self, mapped: MappedSweep, values: Int8[Array, "n n"]) -> bytes:
        """Rows of an OccupancyGrid run along x, one after the other along y: here alone maps are turned."""
        grid = mapped.config.grid
        stamp = self._stamp(mapped)
        info = self._make(
            "nav_msgs/msg/MapMetaData",
            map_load_time=stamp,
            resolution=grid.cell_m,
            width=grid.cells,
            height=grid.cells,
            origin=self._pose(-grid.half_m, -grid.half_m),
        )
        data = np.ascontiguousarray(values.T).reshape(-1)
        return self._bytes("nav_msgs/msg/OccupancyGrid", header=self._header(mapped, MAP_FRAME), info=info, data=data)

    def _matrix(self, values: Float32[Array, "n n"]) -> object:
        """A layer of a GridMap: row 0 is at the front (+x), column 0 at the left (+y), stored column by column."""
        n = values.shape[0]
        data = np.ascontiguousarray(values[::-1, ::-1].T).reshape(-1)
        dimensions = [
            self._make("std_msgs/msg/MultiArrayDimension", label=label, size=n, stride=stride)
            for label, stride in (("column_index", n * n), ("row_index", n))
        ]
        layout = self._make("std_msgs/msg/MultiArrayLayout", dim=dimensions, data_offset=0)
        return self._make("std_msgs/msg/Float32MultiArray", layout=layout, data=data)

    def _make(self, type_name: str, **values: object) -> Any:
        make: Callable[..., Any] = self._store.types[type_name]
        return make(**values)

    def _bytes(self, type_name: str, **values: object) -> bytes:
        return bytes(self._store.serialize_cdr(self._make(type_name, **values), type_name))

    def _stamp(self, mapped: MappedSweep) -> object:
        seconds, nanoseconds = divmod(mapped.sweep.stamp_ns, 10**9)
        return self._make("builtin_interfaces/msg/Time", sec=seconds, nanosec=nanoseconds)

    def _header(self, mapped: MappedSweep, frame: str) -> object:
        return self._make("std_msgs/msg/Header", stamp=self._stamp(mapped), frame_id=frame)

    def _pose(self, x_m: float, y_m: float) -> object:
        position = self._make("geometry_msgs/msg/Point", x=x_m, y=y_m, z=0.0)
        return self._make("geometry_msgs/msg/Pose", position=position, orientation=self._quaternion(0.0))

    def _quaternion(self, yaw_rad: float) -> object:
        x, y, z, w = quaternion_from_rpy(np.array([0.0, 0.0, yaw_rad])).tolist()
        return self._make("geometry_msgs/msg/Quaternion", x=x, y=y, z=z, w=w)
