"""More than one camera and more than one LiDAR: from the robot file to the rows and the whole clouds."""

import json
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from drive_factory import NATIVE, REAR, STREAMS
from hashes import hashes
from ingesting import ingested
from noted import noted

from navtool.base.errors import DatasetsError
from navtool.datasets.check import check_dataset
from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.inspect.inspection import inspect_recording, robot_from
from navtool.datasets.robot.config import RobotConfig, load_robot_file, save_robot_file
from navtool.datasets.robot.sensor_config import CameraFallback, FurtherCamera, FurtherLidar, Mounting
from navtool.datasets.store.reader import NavDataset
from navtool.datasets.streams.config import FurtherSync, SyncConfig
from navtool.datasets.streams.sync import Method
from navtool.pipeline.image_reliability import ImageReliabilityConfig, image_reliability

Write = Callable[..., Path]
Drive = Callable[..., list[Any]]

ALL = (*STREAMS, *REAR)
CAMERA = FurtherCamera(topics=["/rear_camera/image_raw/compressed"])
LIDAR = FurtherLidar(topics=["rear_points"], mounting=Mounting(xyz_m=[-0.4, 0.0, 0.5], rpy_rad=[0.0, 0.0, np.pi]))
ROBOT = RobotConfig(cameras={"rear": CAMERA}, lidars={"rear": LIDAR})


@pytest.fixture(scope="module")
def both(tmp_path_factory: pytest.TempPathFactory, recording_writer: Write, drive_entries: Drive) -> Path:
    """A data set of one drive with a second camera and a second LiDAR; read only."""
    folder = tmp_path_factory.mktemp("both")
    report = ingested([recording_writer(folder, "mcap", drive_entries(streams=ALL))], folder / "out", robot=ROBOT)
    assert report.quarantined == []
    return folder / "out"


@pytest.mark.parametrize("container", ["ros1", "ros1_lz4", "db3", "mcap_zstd"])
def test_every_container_gives_the_same_cameras_and_clouds(
    container: str, both: Path, write_recording: Write, drive_entries: Drive, tmp_path: Path
) -> None:
    entries = drive_entries(streams=ALL, ros1=container.startswith("ros1"))
    report = ingested([write_recording(container, entries)], tmp_path / "out", robot=ROBOT)
    assert (report.rows, report.quarantined) == (30, [])
    expected, found = NavDataset(both), NavDataset(tmp_path / "out")
    assert list(found.features) == list(expected.features)
    for row in (0, 11, 29):
        np.testing.assert_array_equal(found.image(row, "rear"), expected.image(row, "rear"))
    for key in ("valid.camera.rear", "sync.error_s.camera.rear", "reliability.camera.rear"):
        np.testing.assert_array_equal(found.column(key), expected.column(key), err_msg=key)
    clouds, same = list(found.clouds(0, "rear")), list(expected.clouds(0, "rear"))
    assert len(clouds) == len(same) == 15
    for cloud, other in zip(clouds, same, strict=True):
        np.testing.assert_array_equal(cloud.xyz, other.xyz)
        assert (cloud.stamp_ns, cloud.frame_index) == (other.stamp_ns, other.frame_index)


def test_the_second_camera_has_its_own_columns_values_and_pose(both: Path, drive_entries: Drive) -> None:
    dataset = NavDataset(both)
    assert dataset.features["observation.images.rear"] == dataset.features["observation.images.front"]
    assert dataset.column("valid.camera.rear").all()
    np.testing.assert_allclose(dataset.column("sync.error_s.camera.rear"), 0.01, atol=1e-6)
    recorded = [fields for topic, _, _, fields in drive_entries(streams=ALL) if topic.startswith("/rear_camera/image")]
    for row in (0, 17, 29):
        raw = _rgb(recorded[row]["data"])
        whole, brightness, corners = image_reliability(raw, ImageReliabilityConfig())
        found = [
            dataset.column(f"reliability.{name}.rear")[row]
            for name in ("camera", "camera_brightness", "camera_corners")
        ]
        np.testing.assert_allclose(found, [whole, brightness, corners], rtol=1e-6)
        small = _small(raw)
        assert np.abs(dataset.image(row, "rear").astype(int) - small).mean() < 8, "the video is that of this camera"
        assert np.abs(dataset.image(row).astype(int) - small).mean() > 20
    calibration = dataset.calibration(0)
    pose, camera = calibration.poses()["camera.rear"], calibration.camera_of("camera.rear")
    assert pose is not None
    np.testing.assert_allclose(pose[:3, :3] @ [0, 0, 1], [-1, 0, 0], atol=1e-9, err_msg="it looks backwards")
    np.testing.assert_allclose(pose[:3, 3], [-0.3, 0, 0.4])
    assert camera is not None
    assert camera.fx == pytest.approx(0.8 * 320)
    assert calibration.recorded.camera_infos["rear"].camera.width == NATIVE[0]
    assert calibration.sources["camera.rear"].startswith("the recording's CameraInfo")
    assert calibration.recorded.frames["camera.rear"] == "rear_optical"


def _rgb(jpeg: Any) -> Any:
    bgr = cv2.imdecode(np.frombuffer(bytes(jpeg), np.uint8), cv2.IMREAD_COLOR)
    assert bgr is not None
    return cv2.cvtColor(bgr, cv2.COLOR_BGR2RGB)


def _small(rgb: Any) -> Any:
    return cv2.resize(rgb, (320, 240), interpolation=cv2.INTER_LINEAR).astype(int)


def test_the_second_lidar_is_whole_beside_the_rows_with_its_pose(both: Path, drive_entries: Drive) -> None:
    dataset = NavDataset(both)
    recorded = [fields for topic, _, _, fields in drive_entries(streams=ALL) if topic == "/rear_points"]
    clouds = list(dataset.clouds(0, "rear"))
    assert len(clouds) == len(recorded) == 15
    for cloud, fields in zip(clouds, recorded, strict=True):
        first = np.frombuffer(bytes(fields["data"]), "<f4", 3)
        np.testing.assert_array_equal(cloud.xyz[0], first)
    assert [cloud.frame_index for cloud in clouds] == list(range(0, 30, 2)), "the row that each is nearest to"
    np.testing.assert_array_equal(dataset.cloud_stamps(0, "rear"), [cloud.stamp_ns for cloud in clouds])
    assert len(list(dataset.clouds(0))) == 30, "those of the first LiDAR stay apart"
    assert not any("lidar.rear" in key for key in dataset.features)
    pose = dataset.calibration(0).poses()["lidar.rear"]
    assert pose is not None
    np.testing.assert_allclose(pose @ [1, 0, 0, 1], [-1.4, 0, 0.5, 1], atol=1e-9)
    assert dataset.calibration(0).sources["base_lidar.rear"] == "robot robot: lidars.rear.mounting"


def test_the_first_sensors_are_as_without_others(
    both: Path, write_recording: Write, drive_entries: Drive, tmp_path: Path
) -> None:
    """The same rows, and not a word of the others: files of one camera read as before there could be two."""
    ingested([write_recording("mcap", drive_entries())], tmp_path / "one")
    one, two = NavDataset(tmp_path / "one"), NavDataset(both)
    assert set(two.features) - set(one.features) == {
        "observation.images.rear",
        "reliability.camera.rear",
        "reliability.camera_brightness.rear",
        "reliability.camera_corners.rear",
        "sync.error_s.camera.rear",
        "valid.camera.rear",
    }
    for key, feature in one.features.items():
        if feature.dtype != "video" and len(feature.shape) == 1:
            np.testing.assert_array_equal(one.column(key), two.column(key), err_msg=key)
    same = ("data", "videos/observation.images.front", "navtool/episodes/episode-000000/clouds/part-00000.parquet")
    for name in same[1:]:
        assert hashes(tmp_path / "one" / name) == hashes(both / name)
    written = [path for path in (tmp_path / "one").rglob("*.json*") if path.name != "stats.json"]
    assert len(written) > 4
    for path in written:
        text = path.read_text()
        assert not any(word in text for word in ('"cameras"', '"lidars"', '"further"', "rear", "camera_infos")), path


def test_more_workers_and_another_time_give_the_same_bytes(
    write_recording: Write, drive_entries: Drive, tmp_path: Path
) -> None:
    paths = [
        write_recording("mcap", drive_entries(1.5, streams=ALL, seed=seed), name=f"run-{seed}") for seed in range(2)
    ]
    ingested(paths, tmp_path / "one", robot=ROBOT)
    ingested(paths, tmp_path / "two", robot=ROBOT, workers=2)
    assert hashes(tmp_path / "one") == hashes(tmp_path / "two")
    shutil.rmtree(paths[0]) if paths[0].is_dir() else paths[0].unlink()
    longer = write_recording("mcap", drive_entries(2.0, streams=ALL, seed=0), name="run-0")
    report = ingested([longer], tmp_path / "one", robot=ROBOT)
    assert [episode.rebuilt for episode in report.episodes] == [True]
    ingested([longer, *paths[1:]], tmp_path / "new", robot=ROBOT)
    names = [name for name in hashes(tmp_path / "new") if name.startswith(("videos", "data", "meta"))]
    assert len(names) > 6
    assert {n: hashes(tmp_path / "one")[n] for n in names} == {n: hashes(tmp_path / "new")[n] for n in names}


def test_check_finds_nothing_about_them(both: Path) -> None:
    report = check_dataset(both)
    assert report.passed
    assert not any("rear" in finding.where + finding.message for finding in report.findings), report.findings


def test_a_recording_without_them_is_refused_or_taken_as_not_valid(
    both: Path, write_recording: Write, drive_entries: Drive, tmp_path: Path
) -> None:
    shutil.copytree(both, tmp_path / "out")
    lacking = write_recording("mcap", drive_entries(seed=1), name="lacking")
    (refused,) = ingested([lacking], tmp_path / "out", robot=ROBOT).quarantined
    assert "lacks camera.rear, lidar.rear, which the data set has" in refused.reason
    (refused,) = ingested([lacking], tmp_path / "new", robot=ROBOT).quarantined
    assert "lacks camera.rear, lidar.rear" in refused.reason, "the first recording lacks what the robot file names"
    ingested([lacking], tmp_path / "new", robot=ROBOT, allow_missing=True)
    assert NavDataset(tmp_path / "new").features == NavDataset(both).features
    assert not NavDataset(tmp_path / "new").column("valid.camera.rear").any()
    (taken,) = ingested([lacking], tmp_path / "out", robot=ROBOT, allow_missing=True).episodes
    assert noted(taken.notes, "topics.none-of-them")[0].startswith("camera.rear: ")
    dataset = NavDataset(tmp_path / "out")
    rows = slice(dataset.episodes[1].start, dataset.episodes[1].stop)
    assert not dataset.column("valid.camera.rear")[rows].any()
    assert not dataset.column("reliability.camera.rear")[rows].any()
    assert not dataset.image(rows.start, "rear").any()
    assert list(dataset.clouds(1, "rear")) == []
    assert check_dataset(tmp_path / "out").passed


def test_what_a_data_set_of_one_camera_leaves_out_is_said(
    write_recording: Write, drive_entries: Drive, tmp_path: Path
) -> None:
    ingested([write_recording("mcap", drive_entries(), name="first")], tmp_path / "out")
    recording = write_recording("mcap", drive_entries(streams=ALL, seed=1), name="second")
    (episode,) = ingested([recording], tmp_path / "out", robot=ROBOT).episodes
    assert noted(episode.notes, "contents.left-out")[0].startswith("camera.rear, lidar.rear: ")
    assert "valid.camera.rear" not in NavDataset(tmp_path / "out").features


def test_images_that_cannot_be_decoded_are_counted_by_camera(
    write_recording: Write, drive_entries: Drive, tmp_path: Path
) -> None:
    entries = drive_entries(streams=ALL)
    images = [fields for topic, _, _, fields in entries if topic == "/rear_camera/image_raw/compressed"]
    for fields in images[7:9]:
        fields["data"] = fields["data"][:5]
    (episode,) = ingested([write_recording("mcap", entries)], tmp_path / "out", robot=ROBOT).episodes
    assert episode.dropped["camera.rear: cannot be decoded"] == 2
    dataset = NavDataset(tmp_path / "out")
    assert np.flatnonzero(~dataset.column("valid.camera.rear")).tolist() == [7, 8]
    assert dataset.column("valid.camera").all()
    held, before = (dataset.image(row, "rear").astype(int) for row in (7, 6))
    assert np.abs(held - before).mean() < 2, "the one before, as far as the codec keeps it"


def test_a_further_sensors_time_is_set_by_its_name(
    both: Path, write_recording: Write, drive_entries: Drive, tmp_path: Path
) -> None:
    recording = write_recording("mcap", drive_entries(streams=ALL))
    sync = SyncConfig(cameras={"rear": FurtherSync(method=Method.hold, tolerance_s=0.5)})
    (episode,) = ingested([recording], tmp_path / "out", robot=ROBOT, config=IngestConfig(sync=sync)).episodes
    assert (episode.sync["streams"]["camera.rear"]["method"], episode.sync["streams"]["camera"]["method"]) == (
        "hold",
        "nearest",
    )
    assert NavDataset(tmp_path / "out").column("sync.error_s.camera.rear")[5] == pytest.approx(-0.09, abs=1e-6)
    with pytest.raises(DatasetsError, match=r"has sync.cameras.rear.clock=auto, asked for none"):
        ingested([recording], tmp_path / "out", robot=ROBOT)
    with pytest.raises(DatasetsError, match=r"has no sync.cameras.rear.clock, asked for auto"):
        ingested([recording], both, robot=ROBOT, config=IngestConfig(sync=sync))
    with pytest.raises(DatasetsError, match=r"rear: not among robot.cameras; it has no further ones"):
        ingested([recording], tmp_path / "other", config=IngestConfig(sync=sync))


def test_a_rear_camera_alone_makes_a_data_set(write_recording: Write, drive_entries: Drive, tmp_path: Path) -> None:
    recording = write_recording("mcap", drive_entries(streams=("camera.rear", "odometry", "tf")))
    (episode,) = ingested([recording], tmp_path / "out", robot=ROBOT, allow_missing=True).episodes
    dataset = NavDataset(tmp_path / "out")
    assert episode.sync["grid_stream"] == "camera.rear"
    assert "observation.images.front" not in dataset.features
    assert dataset.column("valid.camera.rear").all()
    with pytest.raises(DatasetsError, match="has no camera 'front'") as raised:
        dataset.image(0)
    assert raised.value.cure == "known are rear"
    assert check_dataset(tmp_path / "out").passed


def test_what_is_not_there_is_named_on_reading(both: Path) -> None:
    dataset = NavDataset(both)
    with pytest.raises(DatasetsError, match="has no camera 'left'"):
        dataset.image(0, "left")
    with pytest.raises(DatasetsError, match="has no further LiDAR 'roof'") as raised:
        list(dataset.clouds(0, "roof"))
    assert raised.value.cure == "known are rear"
    with pytest.raises(DatasetsError, match=r"has no column 'observation.images.rear'"):
        dataset.column("observation.images.rear")


def test_check_finds_a_changed_video_and_unknown_geometry(
    write_recording: Write, drive_entries: Drive, tmp_path: Path
) -> None:
    streams = tuple(stream for stream in ALL if stream != "tf")
    robot = RobotConfig(cameras={"rear": CAMERA}, lidars={"rear": replace(LIDAR, mounting=None)})
    (episode,) = ingested(
        [write_recording("mcap", drive_entries(streams=streams))], tmp_path / "out", robot=robot
    ).episodes
    assert "camera.rear: no transform from the base frame to rear_optical and no mounting" in "".join(
        noted(episode.notes, "sensor.no-pose")
    )
    video = NavDataset(tmp_path / "out").layout.video(0, "observation.images.rear")
    video.write_bytes(video.read_bytes() + b"\0")
    found = [f"{finding.where}: {finding.message}" for finding in check_dataset(tmp_path / "out").findings]
    assert any("observation.images.rear" in one and "not those that ingest wrote" in one for one in found)
    assert any("base_camera.rear, base_lidar.rear unknown" in one for one in found), found


def test_a_calibration_from_the_robot_file_stands_in(
    write_recording: Write, drive_entries: Drive, tmp_path: Path
) -> None:
    entries = [entry for entry in drive_entries(streams=ALL) if entry[0] != "/rear_camera/camera_info"]
    fallback = CameraFallback(width=128, height=96, fx=100.0, fy=100.0, cx=64.0, cy=48.0)
    robot = RobotConfig(cameras={"rear": replace(CAMERA, calibration=fallback)}, lidars={"rear": LIDAR})
    ingested([write_recording("mcap", entries)], tmp_path / "out", robot=robot)
    calibration = NavDataset(tmp_path / "out").calibration(0)
    camera = calibration.camera_of("camera.rear")
    assert camera is not None
    assert camera.fx == pytest.approx(250)
    assert calibration.sources["camera.rear"] == "robot robot: cameras.rear.calibration"


def test_inspect_proposes_them_and_the_written_robot_file_reads_them(
    both: Path, write_recording: Write, drive_entries: Drive, tmp_path: Path
) -> None:
    recording = write_recording("mcap", drive_entries(streams=ALL))
    inspection = inspect_recording(recording)
    assert inspection.topic_map.streams["camera"] == "/camera/image_raw/compressed"
    assert inspection.topic_map.further == {
        "camera.rear": "/rear_camera/image_raw/compressed",
        "lidar.rear": "/rear_points",
    }
    assert json.loads(json.dumps(inspection.to_json()))["topic_map"]["further"]["lidar.rear"] == "/rear_points"
    save_robot_file(robot_from(RobotConfig(), inspection), tmp_path / "robot.yaml")
    robot = load_robot_file(tmp_path / "robot.yaml")
    assert list(robot.cameras) == list(robot.lidars) == ["rear"]
    assert inspect_recording(recording, robot).topic_map.further == {}
    report = ingested([recording], tmp_path / "out", robot=robot)
    assert report.quarantined == []
    assert NavDataset(tmp_path / "out").features == NavDataset(both).features
    assert robot_from(robot, inspect_recording(recording, robot)) == robot
