"""Where the sensors sit: chains of transforms, fallbacks, and what stays unknown."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from navtool.base.errors import DatasetsError
from navtool.base.files import write_json
from navtool.datasets.decode.messages import CameraInfoSample, Transform
from navtool.datasets.robot.calibration import CameraImages, calibrate, read_calibration
from navtool.datasets.robot.config import RobotConfig
from navtool.datasets.robot.recorded_geometry import RecordedGeometry, TransformTree, latest_transforms
from navtool.datasets.robot.sensor_config import CameraFallback, Mounting
from navtool.pipeline.geometry.camera import CameraModel
from navtool.pipeline.geometry.transforms import invert_transform, transform_from_xyz_rpy

SMALL = (320, 240)


def _edge(parent: str, child: str, xyz: tuple[float, float, float], yaw: float = 0.0) -> Transform:
    matrix = transform_from_xyz_rpy(np.array(xyz), np.array([0.0, 0.0, yaw]))
    return Transform(parent=parent, child=child, stamp_ns=0, matrix=matrix)


TREE = [
    _edge("base_footprint", "base_link", (0.0, 0.0, 0.3)),
    _edge("base_link", "mast", (0.1, 0.0, 1.0), yaw=np.pi / 2),
    _edge("/mast", "/lidar", (0.2, 0.0, 0.0)),
    _edge("elsewhere", "orphan", (0.0, 0.0, 0.0)),
]


def test_poses_chain_in_both_directions_and_leading_slashes_do_not_matter() -> None:
    tree = TransformTree(TREE)
    pose = tree.pose("base_link", "lidar")
    assert pose is not None
    np.testing.assert_allclose(pose[:3, 3], [0.1, 0.2, 1.0], atol=1e-12)
    back = tree.pose("/lidar", "/base_link")
    assert back is not None
    np.testing.assert_allclose(back, invert_transform(pose), atol=1e-12)
    assert tree.pose("base_link", "orphan") is None
    assert tree.pose("base_link", "unheard_of") is None


def test_tf_wins_over_the_mounting_and_the_rest_stays_unknown() -> None:
    robot = RobotConfig(mounting={"lidar": Mounting(xyz_m=[9.0, 9.0, 9.0]), "imu": Mounting(xyz_m=[0.0, 0.0, 0.5])})
    frames = {"camera": "camera", "lidar": "lidar", "imu": "imu_link"}
    found = calibrate(
        robot, RecordedGeometry(frames, tuple(TREE)), {"camera": CameraImages("/image", (640, 480), SMALL)}
    )
    assert found.base_lidar is not None
    assert found.base_lidar[2, 3] == 1.0
    assert found.base_imu is not None
    assert found.base_imu[2, 3] == 0.5
    assert found.base_camera is None
    assert found.camera is None
    assert found.base_height_m == 0.3
    assert "mounting.imu" in found.sources["base_imu"]


def _info(rectified: float) -> CameraInfoSample:
    projection = np.array([[rectified, 0, 300, 0], [0, rectified, 200, 0], [0, 0, 1, 0]], dtype=np.float64)
    camera = CameraModel(640, 480, 500.0, 510.0, 320.0, 240.0, "plumb_bob", (0.1, 0.0, 0.0, 0.0, 0.0))
    return CameraInfoSample(
        stamp_ns=0, frame_id="camera", camera=camera, rectification=np.eye(3), projection=projection
    )


@pytest.mark.parametrize(
    ("topic", "focal", "distorted"),
    [
        ("/image_raw", 250.0, True),
        ("/image_raw/compressed", 250.0, True),
        ("/image_rect_color/compressed", 200.0, False),
    ],
)
def test_a_rectified_image_is_projected_without_distortion(topic: str, focal: float, distorted: bool) -> None:
    recorded = RecordedGeometry(camera_info=_info(400.0))
    found = calibrate(RobotConfig(), recorded, {"camera": CameraImages(topic, (640, 480), SMALL)})
    assert found.camera is not None
    assert (found.camera.width, found.camera.height) == (320, 240)
    assert found.camera.fx == pytest.approx(focal)
    assert (found.camera.distortion_model != "none") == distorted


def test_a_rectified_image_without_a_projection_is_projected_by_its_intrinsics() -> None:
    info = replace(_info(400.0), projection=np.zeros((3, 4)))
    found = calibrate(
        RobotConfig(), RecordedGeometry(camera_info=info), {"camera": CameraImages("/image_rect", None, SMALL)}
    )
    assert found.camera == replace(info.camera, distortion_model="none", distortion=()).scaled_to(320, 240)
    assert "no projection matrix" in found.sources["camera"]


def test_the_robots_camera_stands_in_and_everything_reads_back_equal(tmp_path: Path) -> None:
    robot = RobotConfig(camera=CameraFallback(width=1920, height=1200, fx=2813.6, fy=2808.3, cx=969.3, cy=625.9))
    recorded = RecordedGeometry({"lidar": "lidar"}, tuple(TREE))
    found = calibrate(robot, recorded, {"camera": CameraImages("/image", (1920, 1200), SMALL)})
    assert found.camera is not None
    assert found.camera.fx == pytest.approx(2813.6 / 6)
    write_json(tmp_path / "calibration.json", found.to_json())
    again = read_calibration(tmp_path / "calibration.json")
    assert again.camera == found.camera
    np.testing.assert_array_equal(again.base_lidar, found.base_lidar)
    assert again.recorded.frames == {"lidar": "lidar"}
    assert [(x.parent, x.child) for x in again.recorded.transforms] == [(x.parent, x.child) for x in TREE]
    np.testing.assert_array_equal(again.recorded.tree.pose("base_link", "lidar"), found.base_lidar)
    (tmp_path / "calibration.json").write_text("{}")
    with pytest.raises(DatasetsError, match="not a calibration"):
        read_calibration(tmp_path / "calibration.json")


def test_the_camera_is_kept_as_it_was_calibrated(tmp_path: Path) -> None:
    recorded = RecordedGeometry(camera_info=_info(400.0))
    found = calibrate(RobotConfig(), recorded, {"camera": CameraImages("/image_raw", (640, 480), SMALL)})
    write_json(tmp_path / "calibration.json", found.to_json())
    info = read_calibration(tmp_path / "calibration.json").recorded.camera_info
    assert info is not None
    assert info.camera == _info(400.0).camera
    np.testing.assert_array_equal(info.projection, _info(400.0).projection)
    np.testing.assert_array_equal(info.rectification, np.eye(3))


def test_a_frame_is_found_behind_the_robots_name() -> None:
    named = [_edge("spot1/body", "spot1/lidar", (0.1, 0.0, 0.4)), _edge("map", "odom", (0.0, 0.0, 0.0))]
    pose = TransformTree(named).pose("body", "spot1/lidar")
    assert pose is not None
    assert pose[2, 3] == 0.4
    two_robots = TransformTree([*named, _edge("spot2/body", "spot2/lidar", (0.1, 0.0, 0.4))])
    assert two_robots.pose("body", "spot1/lidar") is None, "which of the two is meant cannot be told"
    assert two_robots.pose("spot2/body", "/spot2/lidar") is not None


def test_of_a_transform_published_again_the_last_value_counts() -> None:
    once = [_edge("base", "lidar", (0.0, 0.0, 1.0)), _edge("base", "camera", (0.0, 0.0, 2.0))]
    assert latest_transforms([*once, *once]) == (tuple(sorted(once, key=lambda x: x.child)), ())
    kept, changed = latest_transforms([*once, _edge("/base", "lidar", (0.0, 0.0, 1.5))])
    assert changed == ("base -> lidar",)
    assert {x.child: x.matrix[2, 3] for x in kept} == {"lidar": 1.5, "camera": 2.0}
