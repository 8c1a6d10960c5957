"""Real clouds with intensities, from the shared recordings: labelled where they are."""

import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import yaml
from numpy.typing import NDArray
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from navtool.datasets.recording import open_recording
from navtool.datasets.robot.config import RobotConfig
from navtool.datasets.streams.config import SyncConfig
from navtool.methods.along.recorded_streams import RecordedStreams
from navtool.methods.along.sweeps import Sweep, SweepConfig, Sweeps
from navtool.methods.intensity_map.ground_height import height_above_ground

ROOT = Path(__file__).resolve().parents[1]
_SAME_M = 0.3
_CAR = 2.2
"""Farther from the sensor than this, seen from above, no point of RELLIS-3D's or KITTI's vehicle remains."""


@dataclass(frozen=True, slots=True)
class RealCloud:
    """One cloud around its sensor."""

    name: str
    preset: str
    """Preset of the sensor."""
    sensor_height_m: float
    """Above the ground, measured in the cloud itself."""
    xyz: NDArray[np.float32]
    intensity: NDArray[np.float32]
    label: NDArray[np.str_] | None
    """What each point lies on; None where nobody has said."""
    may_be_shown: bool
    """Whether its licence lets pictures of it go into the repository."""


def real_clouds() -> Iterator[RealCloud]:
    """Those that are there; what is missing is told."""
    folder = Path(os.environ.get("NAVTOOL_DATA", ROOT.parent / "shared" / "data")) / "lidar"
    for make in (_rellis_ouster, _rellis_velodyne, _kitti, _vlp16):
        try:
            yield make(folder)
        except FileNotFoundError as error:
            print(f"left out: {error.filename} is missing; NAVTOOL_DATA names the recordings' folder")


def _rellis_ouster(folder: Path) -> RealCloud:
    points, label = _rellis_labelled(folder)
    # the recorder divided the sensor's 16 bits by their largest number
    return _cloud("RELLIS-3D 000104, Ouster OS1-64", "ouster", points, 65535.0, label)


def _rellis_velodyne(folder: Path) -> RealCloud:
    """Labelled as the nearest labelled point of the other sensor on the same roof, within 0.3 m."""
    points = _floats(folder / "rellis3d" / "vel000104.bin")
    text = (folder / "rellis3d" / "vel2os1.yaml").read_text(encoding="utf-8")
    pose = yaml.safe_load(text)["vel2os1"]
    turn = Rotation.from_quat([pose["q"][axis] for axis in "xyzw"])
    other, known = _rellis_labelled(folder)
    told = known != "void"
    in_other = turn.apply(points[:, :3]) + [pose["t"][axis] for axis in "xyz"]
    distance, nearest = cKDTree(other[told, :3]).query(in_other, distance_upper_bound=_SAME_M)
    label = np.full(len(points), "void", dtype=known.dtype)
    found = np.isfinite(distance)
    label[found] = known[told][nearest[found]]
    return _cloud("RELLIS-3D 000104, Velodyne", "vlp16", points, 1.0, label)


def _rellis_labelled(folder: Path) -> tuple[NDArray[np.float32], NDArray[np.str_]]:
    names: dict[int, str] = yaml.safe_load((folder / "rellis3d" / "rellis.yaml").read_text(encoding="utf-8"))["labels"]
    number = np.fromfile(folder / "rellis3d" / "000104.label", "<u4")
    label = np.array([names.get(n, "void") for n in range(int(number.max()) + 1)])[number]
    return _floats(folder / "rellis3d" / "000104.bin"), label


def _kitti(folder: Path) -> RealCloud:
    return _cloud("KITTI 000001, HDL-64E", "hdl64", _floats(folder / "kitti" / "velodyne" / "000001.bin"), 1.0, None)


def _vlp16(folder: Path) -> RealCloud:
    path = folder / "nebula_vlp16" / "1673400471837873222"
    if not path.is_dir():
        raise FileNotFoundError(2, "No such file or directory", str(path))
    with open_recording(path) as recording:
        streams = RecordedStreams(recording, RobotConfig(), SyncConfig(), Sweeps.reads, 0.25)
        read = (reading.read() for reading in Sweeps(SweepConfig(robot_radius_m=0.0)).readings(streams))
        sweep = max((one for one in read if isinstance(one, Sweep)), key=lambda one: len(one.xyz))
    return RealCloud(
        "Nebula's capture, VLP-16", "vlp16", _height(sweep.xyz), sweep.xyz, sweep.intensity, None, may_be_shown=True
    )


def _cloud(
    name: str, preset: str, points: NDArray[np.float32], scale: float, label: NDArray[np.str_] | None
) -> RealCloud:
    kept = np.hypot(points[:, 0], points[:, 1]) > _CAR
    xyz, intensity = points[kept, :3], points[kept, 3] * np.float32(scale)
    label = None if label is None else label[kept]
    return RealCloud(name, preset, _height(xyz), xyz, intensity, label, may_be_shown=False)


def _floats(path: Path) -> NDArray[np.float32]:
    return np.fromfile(path, "<f4").reshape(-1, 4)


def _height(xyz: NDArray[np.float32]) -> float:
    return height_above_ground(xyz) or 1.0
