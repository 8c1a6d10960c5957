"""What a recording itself says of its geometry: frames, static transforms, the camera as calibrated."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from jaxtyping import Float64

from navtool.base.plain import plain
from navtool.datasets.decode.messages import CameraInfoSample, Region, Transform
from navtool.pipeline.arrays import Array
from navtool.pipeline.geometry.camera import CameraModel
from navtool.pipeline.geometry.transforms import invert_transform

_SAME = 1e-6
"""Two matrices closer than this in every element are the same transform, published again."""


class TransformTree:
    """Static transforms as a graph: the pose of any frame in any other that it is connected with.

    Frames are known without a leading slash. A name that no frame has stands for the one frame that ends in it behind
    a slash: drivers put the robot's name before it (``spot1/body`` for ``body``).
    """

    def __init__(self, transforms: Sequence[Transform]) -> None:
        self._edges: dict[str, dict[str, Float64[Array, "4 4"]]] = {}
        for transform in transforms:
            parent, child = transform.parent.lstrip("/"), transform.child.lstrip("/")
            self._edges.setdefault(parent, {})[child] = transform.matrix
            self._edges.setdefault(child, {})[parent] = invert_transform(transform.matrix)

    def frame(self, name: str) -> str:
        """The frame of this name, or the only one that ends in it; the name itself where there is none."""
        bare = name.lstrip("/")
        if bare in self._edges:
            return bare
        ending = [frame for frame in self._edges if frame.endswith(f"/{bare}")]
        return ending[0] if bare and len(ending) == 1 else bare

    def pose(self, target: str, source: str) -> Float64[Array, "4 4"] | None:
        """The pose of ``source`` in ``target`` (p_target = pose @ p_source); None where no path joins them."""
        start, goal = self.frame(target), self.frame(source)
        if start == goal:
            return np.eye(4)
        reached = {start: np.eye(4)}
        border = [start]
        while border:
            frame = border.pop()
            for neighbour, matrix in self._edges.get(frame, {}).items():
                if neighbour not in reached:
                    reached[neighbour] = reached[frame] @ matrix
                    border.append(neighbour)
        return reached.get(goal)


@dataclass(frozen=True, slots=True)
class RecordedGeometry:
    """Frames, static transforms and calibration as recorded, nothing chosen or scaled."""

    frames: Mapping[str, str] = field(default_factory=dict)
    """Frame of each stream as its messages name it; of odometry the child's, in which its speeds are."""
    transforms: tuple[Transform, ...] = ()
    """Every static transform once, by its frames; of one published with several values the last."""
    camera_info: CameraInfoSample | None = None
    """Calibration of the front camera at its own resolution; None where the recording has none."""
    camera_infos: Mapping[str, CameraInfoSample] = field(default_factory=dict)
    """Those of further cameras, by name, where the recording has them."""

    @property
    def tree(self) -> TransformTree:
        """The transforms joined: the pose of any frame in any other."""
        return TransformTree(self.transforms)

    def to_json(self) -> dict[str, object]:
        """As plain JSON values."""
        info = self.camera_info
        further = {name: plain(entry) for name, entry in self.camera_infos.items()}
        return {
            "frames": dict(self.frames),
            "transforms": [plain(transform) for transform in self.transforms],
            "camera_info": None if info is None else plain(info),
            **({"camera_infos": further} if further else {}),
        }

    @classmethod
    def from_json(cls, content: Mapping[str, Any]) -> "RecordedGeometry":
        """What ``to_json`` wrote.

        Raises:
            KeyError, TypeError, ValueError: It is something else.
        """
        info = content["camera_info"]
        return cls(
            frames=dict(content["frames"]),
            transforms=tuple(
                Transform(**entry | {"matrix": np.array(entry["matrix"], np.float64).reshape(4, 4)})
                for entry in content["transforms"]
            ),
            camera_info=None if info is None else _info_from_json(info),
            camera_infos={name: _info_from_json(entry) for name, entry in content.get("camera_infos", {}).items()},
        )

    def info_of(self, camera: str) -> CameraInfoSample | None:
        """The calibration of a camera by the name of its stream behind the dot; of the first camera for none."""
        return self.camera_infos.get(camera) if camera else self.camera_info


def _info_from_json(info: Mapping[str, Any]) -> CameraInfoSample:
    return CameraInfoSample(
        stamp_ns=info["stamp_ns"],
        frame_id=info["frame_id"],
        camera=camera_from_json(info["camera"]),
        rectification=np.array(info["rectification"], np.float64).reshape(3, 3),
        projection=np.array(info["projection"], np.float64).reshape(3, 4),
        region=Region(**{name: tuple(value) for name, value in info.get("region", {}).items()}),
        told=info.get("told", ""),
    )


def camera_from_json(content: Mapping[str, Any]) -> CameraModel:
    """A camera that was written as plain values."""
    return CameraModel(**dict(content) | {"distortion": tuple(content["distortion"])})


def latest_transforms(transforms: Sequence[Transform]) -> tuple[tuple[Transform, ...], tuple[str, ...]]:
    """Each transform once, the last one published of its frames, and the pairs whose value changed meanwhile."""
    latest: dict[tuple[str, str], Transform] = {}
    changed: dict[str, None] = {}
    for transform in transforms:
        key = transform.parent.lstrip("/"), transform.child.lstrip("/")
        before = latest.get(key)
        if before is not None and np.abs(before.matrix - transform.matrix).max() > _SAME:
            changed[f"{key[0]} -> {key[1]}"] = None
        latest[key] = transform
    return tuple(latest[key] for key in sorted(latest)), tuple(changed)
