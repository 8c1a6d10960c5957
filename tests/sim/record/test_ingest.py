"""A simulated recording is a recording like any other: ingest, check and labels take it, and its geometry is true."""

import itertools
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from arc_drive import arc_drive

from navtool.configs.schema import config_folder
from navtool.datasets.check import check_dataset
from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.ingest.ingest import ingest
from navtool.datasets.ingest.report import IngestReport
from navtool.datasets.labels.apply import label_dataset
from navtool.datasets.labels.config import LabelConfig
from navtool.datasets.robot.config import RobotConfig
from navtool.datasets.store.reader import NavDataset
from navtool.pipeline.arrays import Array
from navtool.pipeline.geometry.camera import CameraModel
from navtool.pipeline.geometry.trajectory_image import TrajectoryImageConfig, trajectory_image
from navtool.pipeline.geometry.transforms import apply_transform, invert_transform
from navtool.sim.drive.config import DriveConfig
from navtool.sim.drive.drive import Drive
from navtool.sim.record.bag_format import BagFormat
from navtool.sim.record.config import SimulationConfig
from navtool.sim.record.recorder_config import CameraSetup, RecorderConfig
from navtool.sim.record.rig import CAMERA, LIDAR, RIGS, Rig, RobotKind
from navtool.sim.record.simulate import simulate
from navtool.sim.record.stage import make_stage
from navtool.sim.record.streams import START_NS, TOPICS
from navtool.sim.sensors.camera import Camera
from navtool.sim.world.scenario import ScenarioConfig, load_scenario
from navtool.sim.world.surfaces import surface_number

SECONDS = 3.0
CALIBRATED = CameraSetup(width=320, height=240)


class Ingested(NamedTuple):
    report: IngestReport
    dataset: Path


@pytest.fixture(scope="module", params=list(BagFormat), ids=lambda kind: kind.name)
def ingested(
    request: pytest.FixtureRequest, record: Callable[..., Path], tmp_path_factory: pytest.TempPathFactory
) -> Ingested:
    """A recording without losses, in a folder named after its place."""
    folder = tmp_path_factory.mktemp(request.param.name)
    whole = RecorderConfig(drop_share=0.0)
    path = record(folder / "yard-test-0", request.param, drive=arc_drive(SECONDS), recorder=whole)
    report = ingest([path], folder / "dataset", RobotConfig(), IngestConfig(place="{parent}"))
    assert not report.quarantined
    return Ingested(report, folder / "dataset")


def test_every_moment_has_a_row_and_nothing_is_left_out_unexplained(ingested: Ingested) -> None:
    (episode,) = ingested.report.episodes
    assert 10 * SECONDS - 3 <= episode.rows <= 10 * SECONDS
    assert {topic["name"] for topic in episode.not_used} == {t for t in TOPICS if t.startswith("/ground_truth/")}
    assert all(topic["reason"] for topic in episode.not_used)
    assert sum(ingested.report.dropped.values()) <= 4, ingested.report.dropped
    dataset = NavDataset(ingested.dataset)
    assert [found.place for found in dataset.episodes] == ["yard-test-0"]
    for stream in ("camera", "lidar", "state", "action", "imu", "joints", "battery"):
        assert dataset.column(f"valid.{stream}").mean() > 0.9, stream
    assert check_dataset(ingested.dataset).passed


def test_what_was_driven_is_in_the_columns(ingested: Ingested) -> None:
    dataset = NavDataset(ingested.dataset)
    for column in ("observation.state", "action"):
        np.testing.assert_allclose(dataset.column(column)[2:], np.tile([0.8, 0.3], (len(dataset) - 2, 1)), atol=1e-4)
    stamps = dataset.column("stamp_ns").ravel()
    assert START_NS <= stamps[0] < stamps[-1] <= START_NS + SECONDS * 1e9


def test_the_calibration_is_the_rig(ingested: Ingested) -> None:
    found, rig = NavDataset(ingested.dataset).calibration(0), RIGS[RobotKind.wheeled]
    assert found.base_height_m == pytest.approx(0.165)
    for pose, frame in ((found.base_camera, CAMERA), (found.base_lidar, LIDAR)):
        assert pose is not None
        np.testing.assert_allclose(pose, rig.mount(frame), atol=1e-12)
    assert found.camera is not None
    expected = CALIBRATED.model()
    assert found.camera.fx == pytest.approx(expected.fx)
    assert found.camera.distortion == pytest.approx(expected.distortion)


@pytest.mark.parametrize(("kind", "turn_radps"), list(itertools.product(RobotKind, (0.0, 0.35, -0.35))), ids=str)
def test_the_trajectory_image_lies_on_the_ground_that_is_driven_over(kind: RobotKind, turn_radps: float) -> None:
    rig, speed_mps = RIGS[kind], 0.8
    height_m = -float(rig.mount("base_footprint")[2, 3])
    drive = arc_drive(5.0, speed_mps, turn_radps, start=(-3.0, 0.5, 0.4), height_m=height_m)
    bare = ScenarioConfig(name="bare", side_m=20.0, cell_m=0.5, course_m=6.0, hills_m=0.0, ground="concrete")
    stage = make_stage(bare, 0)
    assert float(np.abs(stage.world.ground.heights_m).max()) < 0.02, "the ground is level"
    model = CALIBRATED.model()
    picture = Camera(model).picture(stage.shader, lambda s: _camera_pose(drive, rig, s), 1e4, np.random.default_rng(0))
    config = TrajectoryImageConfig(horizon=45)
    ground = picture.surface == surface_number("concrete")
    truly = np.zeros(ground.shape, bool)
    points = _points(picture.depth_m, model)[ground.ravel()]
    world = apply_transform(_camera_pose(drive, rig, np.zeros(1))[0], points)
    truly[ground] = driven_over(world, drive, config.horizon * config.dt_s, config.robot_width_m)
    drawn = trajectory_image(
        np.array([speed_mps, turn_radps]), model, rig.mount(CAMERA), config, base_height_m=height_m
    )
    both, either = (drawn > 0) & truly, (drawn > 0) | truly
    assert truly.sum() > 1000, "the swath is in the picture"
    assert both.sum() / either.sum() > 0.95


def _camera_pose(drive: Drive, rig: Rig, time_s: Array) -> Array:
    return drive.pose(time_s) @ rig.mount(CAMERA)


def _points(depth_m: Array, model: CameraModel) -> Array:
    """What each pixel shows, in the optical frame."""
    u, v = np.meshgrid(np.arange(model.width), np.arange(model.height))
    rays = model.rays(np.column_stack([u.ravel(), v.ravel()]).astype(np.float64)).directions
    return np.asarray(rays * depth_m.reshape(-1, 1))


def driven_over(points: Array, drive: Drive, until_s: float, width_m: float) -> Array:
    """Whether the robot's cross-section passes over points of the world: one moment after another."""
    passed = np.zeros(len(points), bool)
    before = None
    for time_s in np.arange(0.0, until_s + 1e-9, 0.05):  # 4 cm at 0.8 m/s, less than what counts as passed
        local = apply_transform(invert_transform(drive.pose(np.array([time_s]))[0]), points)
        ahead = local[:, 0] > 0
        if before is not None:
            passed |= before & ~ahead & (np.abs(local[:, 1]) < width_m / 2) & (np.abs(local[:, 0]) < 0.1)
        before = ahead
    return passed


@pytest.mark.slow
def test_what_labels_call_failed_went_wrong(tiny: Callable[..., SimulationConfig], tmp_path: Path) -> None:
    demo = load_scenario(config_folder() / "scenario" / "demo.yaml")
    config = tiny(scenario=demo, drive=DriveConfig(duration_s=40.0, mischief=0.8))
    report = simulate(config, tmp_path / "recordings", 2)
    paths = [tmp_path / "recordings" / episode.plan.path for episode in report.episodes]
    ingest(paths, tmp_path / "dataset", RobotConfig(), IngestConfig(place="{parent}"))
    label_dataset(tmp_path / "dataset", LabelConfig())
    dataset = NavDataset(tmp_path / "dataset")
    failed = dataset.column("label.outcome").ravel() == 0
    stamps = dataset.column("stamp_ns").ravel()
    true = np.zeros(len(stamps), bool)
    for episode in report.episodes:
        for failure in episode.failures:
            begin, end = (episode.plan.start_ns + round(s * 1e9) for s in (failure.start_s, failure.end_s))
            true |= (stamps >= begin) & (stamps <= end)
    assert true.any(), "something went wrong"
    assert failed.any(), "and labels found some of it"
    assert (true & failed).sum() > 0.8 * failed.sum(), "labels may be late in ending, but are not made up"
