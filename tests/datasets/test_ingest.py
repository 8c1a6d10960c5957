"""Ingest as a whole: every container gives the same rows, nothing is lost unsaid, nothing half-written stays."""

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap.writer import Writer

from navtool.datasets.check import check_dataset
from navtool.datasets.errors import DatasetsError
from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.ingest.ingest import ingest
from navtool.datasets.ingest.report import IngestReport
from navtool.datasets.ingest.steps import segment_step
from navtool.datasets.ingest.store import open_store
from navtool.datasets.journal import journal_path
from navtool.datasets.lineage import file_sha256
from navtool.datasets.reader import NavDataset
from navtool.datasets.robot import RobotConfig, TopicCandidates

Write = Callable[..., Path]
Drive = Callable[..., list[Any]]


def _ingest(paths: list[Path], out: Path, **options: Any) -> IngestReport:
    return ingest(paths, out, options.pop("robot", RobotConfig()), options.pop("config", IngestConfig()), **options)


def _hashes(root: Path) -> dict[str, str]:
    return {path.relative_to(root).as_posix(): file_sha256(path) for path in sorted(root.rglob("*")) if path.is_file()}


@pytest.mark.parametrize("container", ["ros1", "ros1_bz2", "ros1_lz4", "db3", "mcap", "mcap_zstd"])
def test_every_container_gives_the_same_rows(
    container: str, write_recording: Write, drive_entries: Drive, tmp_path: Path
) -> None:
    reference = tmp_path / "reference"
    _ingest([write_recording("mcap", drive_entries(), name="a")], reference)
    out = tmp_path / "out"
    report = _ingest([write_recording(container, drive_entries(ros1=container.startswith("ros1")), name="b")], out)
    assert report.rows == 30
    expected, found = NavDataset(reference), NavDataset(out)
    assert expected.features == found.features
    for key, feature in expected.features.items():
        if feature.dtype != "video" and len(feature.shape) == 1:
            np.testing.assert_array_equal(expected.column(key), found.column(key), err_msg=key)
    for row in (0, 7, 29):
        np.testing.assert_array_equal(expected.points(row), found.points(row))
        np.testing.assert_array_equal(expected.image(row), found.image(row))


def test_values_are_those_of_the_drive(write_recording: Write, drive_entries: Drive, tmp_path: Path) -> None:
    out = tmp_path / "out"
    report = _ingest([write_recording("mcap", drive_entries(crash=False))], out)
    dataset = NavDataset(out)
    state, pose = dataset.column("observation.state"), dataset.column("observation.pose")
    valid = dataset.column("valid.state")
    assert valid.sum() >= 29
    np.testing.assert_allclose(state[valid], np.tile([1.0, 0.0], (valid.sum(), 1)), atol=1e-6)
    np.testing.assert_allclose(pose[valid, 0], np.arange(30)[valid] / 10, atol=1e-5)
    np.testing.assert_array_equal(dataset.column("action")[dataset.column("valid.action")][:, 0], 1.0)
    proprioception = dataset.column("observation.proprioception")[5]
    np.testing.assert_allclose(proprioception, [2.5, 5.0, 5.0, 10.0, 1.0, 2.0, 4.0], atol=1e-5)
    np.testing.assert_allclose(dataset.column("observation.imu")[5], [0, 0, 9.81, 0, 0, 0], atol=1e-5)
    assert np.diff(dataset.column("observation.timestamp_ns")).tolist() == [100_000_000] * 29
    np.testing.assert_allclose(dataset.column("sync.error_s.lidar")[:29], 0.02, atol=1e-6)
    assert (dataset.column("label.outcome") == 1).all()
    assert not dataset.column("label.known").any()
    # 45 frames at 15 Hz serve 30 ticks; every message is in a row or counted with a reason
    assert report.dropped == {
        "image: another message is nearer to the tick": 14,
        "image: outside the grid": 1,
        "lidar: outside the grid": 1,
    }
    assert check_dataset(out).passed


def test_a_battery_without_joints_is_a_column_of_its_own(
    write_recording: Write, drive_entries: Drive, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    report = _ingest([write_recording("mcap", drive_entries(streams=("odometry", "battery")))], out)
    assert report.quarantined == []
    dataset = NavDataset(out)
    column = dataset.column("observation.proprioception")
    assert dataset.features["observation.proprioception"].names == ("battery_current_a",)
    np.testing.assert_array_equal(column[dataset.column("valid.battery")], [[4.0]] * 30)
    assert check_dataset(out).passed


def test_clouds_lie_in_the_robot_frame_in_front_and_whole_beside(
    write_recording: Write, drive_entries: Drive, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    _ingest([write_recording("mcap", drive_entries())], out)
    dataset = NavDataset(out)
    counts = dataset.column("observation.lidar.count")
    points = dataset.points(3)[: counts[3]]
    assert counts[3] > 100
    assert (points[:, 0] >= 0).all()
    assert points[:, 2].min() > -0.5 + 0.6 - 1e-3, "the lidar sits 0.6 m above the base"
    assert np.abs(points * 1000 - np.rint(points * 1000)).max() < 1e-2
    clouds = list(dataset.clouds(0))
    assert [cloud.frame_index for cloud in clouds] == list(range(30))
    assert all(len(cloud.xyz) == 600 for cloud in clouds)
    assert clouds[3].intensity is not None
    assert clouds[3].intensity.shape == (600,)
    imu = dataset.stream(0, "imu")
    assert imu is not None
    assert len(imu["stamp_ns"]) == 300
    assert (imu["record_ns"] - imu["stamp_ns"] == 3_000_000).all()


def test_the_same_input_gives_the_same_bytes(write_recording: Write, drive_entries: Drive, tmp_path: Path) -> None:
    path = write_recording("mcap", drive_entries())
    _ingest([path], tmp_path / "first")
    _ingest([path], tmp_path / "second")
    assert _hashes(tmp_path / "first") == _hashes(tmp_path / "second")


def test_later_commands_append_and_known_recordings_are_skipped(
    write_recording: Write, drive_entries: Drive, tmp_path: Path
) -> None:
    first = write_recording("mcap", drive_entries(seed=1), name="run-2")
    second = write_recording("mcap", drive_entries(seed=2), name="run-10")
    both, grown = tmp_path / "both", tmp_path / "grown"
    report = _ingest([second, first], both)
    assert [episode.source.rsplit("/", 1)[1] for episode in report.episodes] == ["run-2", "run-10"]
    _ingest([first], grown)
    again = _ingest([first, second], grown)
    assert len(again.skipped) == 1
    assert again.rows == 30
    assert _hashes(both) == _hashes(grown)
    third = write_recording("mcap", drive_entries(seed=3), name="run-11")
    for paths in ([first], [third]):
        with pytest.raises(DatasetsError, match=r"voxel_m=0.05, asked for 0.2"):
            _ingest(paths, grown, config=IngestConfig(voxel_m=0.2))
        with pytest.raises(DatasetsError, match=r"fps=10, asked for 5"):
            _ingest(paths, grown, config=IngestConfig(fps=5))
    assert _hashes(both) == _hashes(grown)
    assert _ingest([third], grown, config=IngestConfig(place="elsewhere")).rows == 30


def test_a_recording_that_lacks_streams_is_refused_or_marked(
    write_recording: Write, drive_entries: Drive, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    _ingest([write_recording("mcap", drive_entries(), name="full")], out)
    poor = write_recording("mcap", drive_entries(seed=3, streams=("odometry", "image")), name="poor")
    refused = _ingest([poor], out)
    assert "lacks lidar, imu, joints, battery" in refused.quarantined[0].reason
    assert len(NavDataset(out)) == 30
    taken = _ingest([poor], out, allow_missing=True)
    assert taken.rows == 30
    dataset = NavDataset(out)
    for stream in ("lidar", "imu", "joints", "battery", "action"):
        assert not dataset.column(f"valid.{stream}")[30:].any()
    assert not dataset.points(45).any()
    assert check_dataset(out).passed


def test_a_gap_stays_in_its_episode_and_is_marked(write_recording: Write, drive_entries: Drive, tmp_path: Path) -> None:
    entries = drive_entries()
    start = entries[0][2]
    torn = [entry for entry in entries if entry[0] != "/points" or not 0.9e9 < entry[2] - start < 1.6e9]
    out = tmp_path / "out"
    _ingest([write_recording("mcap", torn)], out)
    dataset = NavDataset(out)
    valid = dataset.column("valid.lidar")
    assert not valid[10:15].any()
    assert valid[:9].all()
    assert valid[17:].all()
    assert len(dataset.episodes) == 1
    assert not dataset.column("observation.lidar.count")[~valid].any()


def test_undecodable_messages_are_counted_and_marked(
    write_recording: Write, drive_entries: Drive, tmp_path: Path
) -> None:
    entries = drive_entries()
    broken = [
        (topic, kind, stamp, fields | {"data": fields["data"][:40]})
        if topic.endswith("compressed") and number % 7 == 5
        else (topic, kind, stamp, fields)
        for number, (topic, kind, stamp, fields) in enumerate(entries)
    ]
    out = tmp_path / "out"
    report = _ingest([write_recording("mcap", broken)], out)
    lost = int((~NavDataset(out).column("valid.image")).sum())
    assert lost > 0
    assert report.dropped["image: cannot be decoded"] == lost
    assert check_dataset(out).passed


def test_bad_recordings_are_quarantined_with_a_reason_and_leave_nothing(
    write_recording: Write, drive_entries: Drive, tmp_path: Path
) -> None:
    good = write_recording("mcap", drive_entries(), name="good")
    text = tmp_path / "notes.bag"
    text.write_text("not a bag")
    whole = write_recording("ros1", drive_entries(ros1=True), name="whole").read_bytes()
    torn = tmp_path / "torn.bag"
    torn.write_bytes(whole[:9000])  # within the definitions that precede the messages
    imu = write_recording("mcap", drive_entries(streams=("imu",)), name="imu")
    short = write_recording("mcap", drive_entries(0.1, streams=("odometry",)), name="short")
    out = tmp_path / "out"
    report = _ingest([good, text, torn, imu, short], out)
    assert len(report.episodes) == 1
    reasons = {Path(entry.path).name: entry.reason for entry in report.quarantined}
    assert set(reasons) == {"notes.bag", "torn.bag", "imu", "short"}
    assert "no usable stream" in reasons["imu"]
    assert "less than two ticks" in reasons["short"]
    assert not (out / "navtool" / "staging").exists()
    alone = tmp_path / "alone"
    assert _ingest([text], alone).episodes == []
    assert not alone.exists(), "no data set, no folder"


def test_a_torn_recording_gives_the_rows_it_still_has_and_says_so(
    write_recording: Write, drive_entries: Drive, tmp_path: Path
) -> None:
    whole = write_recording("ros1", drive_entries(8.0, ros1=True), name="whole").read_bytes()
    torn = tmp_path / "torn.bag"
    torn.write_bytes(whole[: len(whole) * 3 // 4])
    out = tmp_path / "out"
    report = _ingest([torn], out)
    assert report.quarantined == []
    assert 45 < report.episodes[0].rows < 75
    assert any(note.startswith("recovered: cut off after") for note in report.episodes[0].notes)
    made = json.loads((NavDataset(out).layout.episode(0) / "provenance.json").read_text())
    assert any("cut off after" in fault for fault in made["recovered"])
    assert check_dataset(out).passed


def test_named_topics_are_not_replaced_by_guesses(write_recording: Write, drive_entries: Drive, tmp_path: Path) -> None:
    robot = RobotConfig(topics=TopicCandidates(image=["none"], lidar=["/absent"]))
    report = _ingest([write_recording("mcap", drive_entries())], tmp_path / "out", robot=robot)
    episode = report.episodes[0]
    assert "image" not in episode.topics
    assert "lidar" not in episode.topics
    assert any("/absent" in note for note in episode.notes)
    assert {"/points", "/camera/image_raw/compressed"} <= {topic["name"] for topic in episode.not_used}


def test_dry_run_writes_nothing(write_recording: Write, drive_entries: Drive, tmp_path: Path) -> None:
    path = write_recording("mcap", drive_entries())
    report = _ingest([path], tmp_path / "out", dry_run=True)
    assert report.rows == 30
    assert not (tmp_path / "out").exists()


def test_a_dry_run_foretells_what_an_ingest_does(write_recording: Write, drive_entries: Drive, tmp_path: Path) -> None:
    """Of each recording, against an existing data set: kept, moved elsewhere, rebuilt, refused, added, added twice."""
    sound, other = write_recording("mcap", drive_entries()), write_recording("mcap", drive_entries(seed=1), "grown")
    out, robot = tmp_path / "out", RobotConfig()
    _ingest([sound, other], out)
    shutil.rmtree(other)
    write_recording("mcap", drive_entries(4.0, seed=1), "grown")
    blind = [entry for entry in drive_entries(seed=2) if "camera" not in entry[0]]
    new = write_recording("mcap", drive_entries(seed=3), "new")
    copy = shutil.copytree(new, tmp_path / "zz-copy")
    broken = tmp_path / "broken.mcap"
    broken.write_bytes(b"nothing")
    paths = [sound, other, write_recording("mcap", blind, "blind"), new, copy, broken]
    before = _state(out)
    config = IngestConfig(place="yard")
    planned = ingest(paths, out, robot, config, dry_run=True)
    assert _state(out) == before
    done = ingest(paths, out, robot, config)
    for report in (planned, done):
        assert len(report.skipped) == 2, "the sound one, and the second of two that are the same"
        assert [(episode.episode, episode.rebuilt) for episode in report.episodes] == [(1, True), (2, False)]
        assert [Path(entry.path).name for entry in report.quarantined] == ["blind", "broken.mcap"]
    assert planned.episodes_before == 2
    assert planned.placed == done.placed
    assert planned.quarantined == done.quarantined
    assert [episode.rows for episode in planned.episodes] == [episode.rows for episode in done.episodes]
    with pytest.raises(DatasetsError, match="the data set has fps=10, asked for 5"):
        ingest(paths, out, robot, IngestConfig(fps=5), dry_run=True)


def _state(folder: Path) -> dict[str, tuple[int, int]]:
    stats = {str(path): path.stat() for path in folder.rglob("*")}
    return {name: (stat.st_mtime_ns, stat.st_size) for name, stat in stats.items()}


def test_a_dry_run_for_a_new_data_set_takes_the_first_recording_for_all(
    write_recording: Write, drive_entries: Drive, tmp_path: Path
) -> None:
    blind = [entry for entry in drive_entries(seed=2) if "camera" not in entry[0]]
    paths = [write_recording("mcap", drive_entries(), "a"), write_recording("mcap", blind, "b")]
    out = tmp_path / "out"
    planned = ingest(paths, out, RobotConfig(), IngestConfig(), dry_run=True)
    assert not out.exists()
    assert [Path(entry.path).name for entry in planned.quarantined] == ["b"]
    assert "lacks image" in planned.quarantined[0].reason


def test_a_dry_run_waits_for_no_interrupted_step(write_recording: Write, drive_entries: Drive, tmp_path: Path) -> None:
    path, out = write_recording("mcap", drive_entries()), tmp_path / "out"
    _ingest([path], out)
    journal_path(out).write_text('{"files": ["meta/info.json"]}')
    with pytest.raises(DatasetsError, match="was interrupted"):
        _ingest([path], out, dry_run=True)
    assert journal_path(out).exists()


def test_one_writer_at_a_time(write_recording: Write, drive_entries: Drive, tmp_path: Path) -> None:
    path = write_recording("mcap", drive_entries())
    out = tmp_path / "out"
    _ingest([path], out)
    with open_store(out), pytest.raises(DatasetsError, match="another process is writing"):
        _ingest([path], out)


def test_an_interrupted_commit_leaves_no_trace(write_recording: Write, drive_entries: Drive, tmp_path: Path) -> None:
    out = tmp_path / "out"
    _ingest([write_recording("mcap", drive_entries(seed=1), name="a")], out)
    before = _hashes(out)
    layout = NavDataset(out).layout
    layout.data(1).write_bytes(b"half")
    layout.episode(1).mkdir(parents=True)
    layout.staging.mkdir()
    second = write_recording("mcap", drive_entries(seed=2), name="b")
    with open_store(out):
        assert _hashes(out) == before
    assert _ingest([second], out).episodes[0].episode == 1
    assert check_dataset(out).passed


def test_foreign_folders_and_other_versions_are_refused(
    write_recording: Write, drive_entries: Drive, tmp_path: Path
) -> None:
    path = write_recording("mcap", drive_entries())
    foreign = tmp_path / "foreign"
    foreign.mkdir()
    (foreign / "thesis.tex").write_text("")
    with pytest.raises(DatasetsError, match="something else"):
        _ingest([path], foreign)
    out = tmp_path / "out"
    _ingest([path], out)
    description = out / "navtool" / "dataset.json"
    content = json.loads(description.read_text())
    description.write_text(json.dumps(content | {"schema_version": 99}))
    for work in (lambda: _ingest([path], out), lambda: NavDataset(out), lambda: check_dataset(out)):
        with pytest.raises(DatasetsError, match="schema version 99"):
            work()


def test_rows_begin_with_the_first_measured_speed(write_recording: Write, drive_entries: Drive, tmp_path: Path) -> None:
    entries = drive_entries()
    late = [entry for entry in entries if entry[0] != "/odom" or entry[2] - entries[0][2] > 450_000_000]
    out = tmp_path / "out"
    report = _ingest([write_recording("mcap", late)], out)
    dataset = NavDataset(out)
    assert len(dataset) == 25
    assert dataset.column("valid.state").all()
    assert report.dropped["image: outside the grid"] > 0
    frames = dataset.column("sync.error_s.image")
    assert np.abs(frames).max() < 0.04, "the ticks keep the camera's phase"


def test_a_recording_that_fails_late_leaves_nothing_to_the_next(
    write_recording: Write, drive_entries: Drive, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    first = write_recording("mcap", drive_entries(seed=1), name="a")
    rest = ("image", "lidar", "odometry", "imu", "joints", "battery", "tf")
    second = write_recording("mcap", drive_entries(seed=2, streams=rest), name="b")

    def fail_once(*arguments: Any) -> None:
        segment_step(*arguments)
        monkeypatch.undo()
        raise DatasetsError("the second reading failed")

    monkeypatch.setattr("navtool.datasets.ingest.ingest.segment_step", fail_once)
    report = _ingest([first, second], tmp_path / "out")
    assert [entry.reason for entry in report.quarantined] == ["the second reading failed"]
    streams = NavDataset(tmp_path / "out").layout.episode(0) / "streams"
    assert not (streams / "command.parquet").exists()
    assert not (streams / "intervention.parquet").exists()
    assert (streams / "odometry.parquet").exists()


def test_a_message_cut_within_its_header_costs_that_message_alone(
    recording_writer: Callable[..., Path], drive_entries: Drive, tmp_path: Path
) -> None:
    path = recording_writer(tmp_path, "mcap_unchunked", drive_entries(), "whole")
    out = tmp_path / "out"
    with path.open("rb") as source, (tmp_path / "cut.mcap").open("wb") as target:
        writer = Writer(target)
        writer.start(profile="ros2")
        channels: dict[int, int] = {}
        for number, (schema, channel, message) in enumerate(make_reader(source).iter_messages()):
            assert schema is not None
            if channel.id not in channels:
                kept = writer.register_schema(schema.name, schema.encoding, schema.data)
                channels[channel.id] = writer.register_channel(channel.topic, channel.message_encoding, kept)
            data = message.data[:6] if channel.topic == "/points" and number % 5 == 0 else message.data
            writer.add_message(channels[channel.id], message.log_time, data, message.publish_time)
        writer.finish()  # type: ignore[no-untyped-call]
    report = _ingest([tmp_path / "cut.mcap"], out)
    assert report.quarantined == []
    lost = int((~NavDataset(out).column("valid.lidar")).sum())
    assert 0 < lost < 15
    assert report.dropped["lidar: no stamp"] > 0
    assert check_dataset(out).passed


def test_what_the_rows_have_no_column_for_is_kept_beside_them(
    write_recording: Callable[..., Path], drive_entries: Callable[..., Any], tmp_path: Path
) -> None:
    first = write_recording("mcap", drive_entries(2.0, streams=("odometry",)), name="first")
    more = write_recording("mcap", drive_entries(2.0, seed=1, streams=("odometry", "lidar", "imu")), name="more")
    report = ingest([first, more], tmp_path / "out", RobotConfig(), IngestConfig())
    assert len(report.episodes) == 2
    assert any("lidar, imu: not in the rows" in note for note in report.episodes[1].notes)
    dataset = NavDataset(tmp_path / "out")
    assert "observation.lidar.points" not in dataset.features
    assert len(list(dataset.clouds(0))) == 0
    clouds = list(dataset.clouds(1))
    assert len(clouds) == 20
    assert all(len(cloud.xyz) == 600 for cloud in clouds)
    imu = dataset.stream(1, "imu")
    assert imu is not None
    assert len(imu["stamp_ns"]) == 200
    assert check_dataset(tmp_path / "out").passed


def test_the_place_of_an_episode_can_be_named_later(
    write_recording: Callable[..., Path], drive_entries: Callable[..., Any], tmp_path: Path
) -> None:
    path = write_recording("mcap", drive_entries(2.0, streams=("odometry",)))
    ingest([path], tmp_path / "out", RobotConfig(), IngestConfig())
    named = ingest([path], tmp_path / "out", RobotConfig(), IngestConfig(place="campus"))
    assert len(named.skipped) == 1
    assert list(named.placed.values()) == ["campus"]
    assert NavDataset(tmp_path / "out").episodes[0].place == "campus"
    assert ingest([path], tmp_path / "out", RobotConfig(), IngestConfig(place="campus")).placed == {}
    (tmp_path / "forest").mkdir()
    (tmp_path / "forest" / "run.mcap").symlink_to(path)
    ingest([tmp_path / "forest" / "run.mcap"], tmp_path / "out", RobotConfig(), IngestConfig(place="{parent}"))
    assert NavDataset(tmp_path / "out").episodes[0].place == "forest", "the folder by which it is reached"
    with pytest.raises(ValueError, match=r"place = \{parnt\}"):
        IngestConfig(place="{parnt}")
