"""One topic, several sources: joints are joined by name, sensors told apart, and nothing is mixed or all zeros."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from ingesting import ingested
from noted import noted
from planning import planned
from shared_topics import (
    ARM,
    FRONT,
    REAR,
    WHEELS,
    angle,
    two_imus,
    two_joint_publishers,
    two_lidars,
    two_nodes,
)

from navtool.datasets.ingest.plan import EpisodePlan
from navtool.datasets.robot.config import RobotConfig
from navtool.datasets.robot.sensor_config import FurtherLidar
from navtool.datasets.store.reader import NavDataset
from navtool.datasets.store.schema import IMU_KEY, PROPRIOCEPTION_KEY
from navtool.pipeline.arrays import Array

type Write = Callable[..., Path]
CODE = "topic.several-sources"


def poles(dataset: NavDataset) -> set[float]:
    """Where the pole stands in the rows that have a cloud, to a decimetre; rows hold what is ahead alone, 0 is none."""
    rows = np.flatnonzero(dataset.column("valid.lidar"))
    assert rows.size > 20
    return {round(float(np.median(dataset.points(int(row))[:, 0])), 1) for row in rows}


@pytest.mark.parametrize(("frame", "ahead_m"), [("", 1.9), (FRONT, 1.9), (REAR, 0.0)])
def test_two_sensors_one_topic(write_recording: Write, tmp_path: Path, frame: str, ahead_m: float) -> None:
    robot = RobotConfig(frames={"lidar": frame} if frame else {})
    report = ingested([write_recording("mcap", two_lidars())], tmp_path / "data", robot=robot)
    (episode,) = report.episodes
    (note,) = noted(episode.notes, CODE)
    assert FRONT in note
    assert REAR in note
    assert episode.dropped["lidar: of another source on its topic"] == 30
    assert poles(NavDataset(tmp_path / "data")) == {ahead_m}


def test_the_second_of_two_sensors_is_read_beside_where_its_frame_is_named(
    write_recording: Write, tmp_path: Path
) -> None:
    robot = RobotConfig(lidars={"rear": FurtherLidar(topics=["/points"], frame=REAR)})
    report = ingested([write_recording("mcap", two_lidars())], tmp_path / "data", robot=robot)
    (episode,) = report.episodes
    assert not noted(episode.notes, CODE)
    dataset = NavDataset(tmp_path / "data")
    assert poles(dataset) == {1.9}
    for sensor, numbers in (("", range(0, 60, 2)), ("rear", range(1, 60, 2))):
        clouds = dataset.clouds(0, sensor or None)
        assert [int(cloud.intensity[0]) for cloud in clouds if cloud.intensity is not None] == list(numbers)


def test_a_sensor_whose_frame_changes_on_the_way_is_not_mixed(write_recording: Write) -> None:
    plan = planned(write_recording("mcap", two_lidars(one_after_the_other=True)))
    assert len(noted(plan.notes, CODE)) == 1
    assert plan.columns["valid.lidar"].mean() < 0.6


def test_two_imus_one_topic(write_recording: Write) -> None:
    path = write_recording("mcap", two_imus())
    for robot in (RobotConfig(), RobotConfig(frames={"imu": "imu_a"})):
        plan = planned(path, robot)
        values = plan.columns[IMU_KEY][plan.columns["valid.imu"]]
        assert len(values) > 20
        np.testing.assert_allclose(values[:, 2], 9.81, atol=1e-4)
        np.testing.assert_allclose(values[:, 5], 0.4, atol=1e-4)
        assert len(noted(plan.notes, CODE)) == 1


def test_nodes_tell_odometries_apart_where_the_recording_names_them(tmp_path: Path) -> None:
    plan = planned(two_nodes(tmp_path / "two.bag"))
    (note,) = noted(plan.notes, CODE)
    assert "node /ekf" in note
    assert "node /wheels" in note
    assert np.ptp(plan.columns["observation.pose"][:, 0]) < 0.5


def joint_columns(plan: EpisodePlan, kind: int = 0) -> dict[str, Array]:
    names = plan.contents.joint_names
    table = plan.columns[PROPRIOCEPTION_KEY]
    return {name: table[:, kind * len(names) + n] for n, name in enumerate(names)}


def along(plan: EpisodePlan) -> Array:
    seconds: Array = (plan.ticks_ns - plan.ticks_ns[0]) * 1e-9
    return seconds


@pytest.mark.parametrize("later_s", [0.007, 0.0])
def test_joints_of_two_publishers_are_joined_by_name(write_recording: Write, later_s: float) -> None:
    plan = planned(write_recording("mcap", two_joint_publishers(later_s=later_s)))
    found = joint_columns(plan)
    assert set(found) == {*ARM, *WHEELS}
    assert plan.columns["valid.joints"][1:-1].all()
    for name, values in found.items():
        np.testing.assert_allclose(values[1:-1], [angle(name, t) for t in along(plan)[1:-1]], atol=1e-5)
    assert len(noted(plan.notes, "joints.joined")) == 1
    assert not [reason for reason in plan.dropped if reason.startswith("joints")]


def test_a_configured_order_leaves_other_publishers_out(write_recording: Write) -> None:
    robot = RobotConfig(joint_names=["right_wheel", "left_wheel"])
    plan = planned(write_recording("mcap", two_joint_publishers()), robot)
    assert list(joint_columns(plan)) == ["right_wheel", "left_wheel"]
    assert plan.columns["valid.joints"][1:-1].all()
    assert plan.dropped["joints: of another source on its topic"] == 150


def test_a_publisher_that_fills_in_what_it_does_not_measure_is_not_believed(write_recording: Write) -> None:
    plan = planned(write_recording("mcap", two_joint_publishers(second=(*WHEELS, "elbow"), still=("elbow",))))
    elbow = joint_columns(plan)["elbow"]
    np.testing.assert_allclose(elbow[1:-1], [angle("elbow", t) for t in along(plan)[1:-1]], atol=1e-5)
    assert len(noted(plan.notes, "joints.published-twice")) == 1


def test_a_slow_publisher_does_not_blank_the_others(write_recording: Write) -> None:
    entries = [
        entry
        for number, entry in enumerate(two_joint_publishers())
        if entry[0] != "/joint_states" or "left_wheel" in entry[3]["name"] or number % 40 == 0
    ]
    plan = planned(write_recording("mcap", entries))
    left = joint_columns(plan)["left_wheel"]
    np.testing.assert_allclose(left[1:-1], [angle("left_wheel", t) for t in along(plan)[1:-1]], atol=1e-5)
