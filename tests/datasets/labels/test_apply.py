"""Labelling a data set that ingest wrote: the right rows, all or nothing, and nothing else touched."""

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest
from counted import Counted

from navtool.base.errors import DatasetsError
from navtool.base.progress import Silent
from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.ingest.ingest import ingest
from navtool.datasets.labels.apply import label_dataset
from navtool.datasets.labels.config import CollisionConfig, LabelConfig, StuckConfig
from navtool.datasets.labels.report import LabelReport
from navtool.datasets.robot.config import RobotConfig
from navtool.datasets.robot.odometry_twist import OdometryTwist
from navtool.datasets.store import journal
from navtool.datasets.store.journal import journal_path, recover
from navtool.datasets.store.reader import NavDataset

SECOND = 1_000_000_000
START = 1_600_000_000 * SECOND
DURATION_S = 16.0
CRASH_S = 5.0
STUCK_S = (9.0, 12.0)
OPERATOR_S = (14.0, 15.0)
KILLED = 9

LABEL_AND_DIE = f"""
import os, sys
from pathlib import Path
from navtool.base.progress import Silent
from navtool.datasets.labels import apply
from navtool.datasets.labels.config import LabelConfig
from navtool.datasets.store import journal
stage, at = sys.argv[2], int(sys.argv[3])
def die(done):
    if done == at:
        os._exit({KILLED})
class Killer(Silent):
    worked = 0
    def advance(self, done, spared):
        self.worked += done
        if stage == "write":
            die(self.worked)
if stage == "replace":
    apply.commit = lambda root, targets: journal.commit(root, targets, die)
apply.label_dataset(Path(sys.argv[1]), LabelConfig(), progress=Killer())
"""


def speed_at(time_s: float) -> float:
    """1 m/s, but for a stop at the crash and while stuck."""
    return 0.0 if CRASH_S <= time_s < CRASH_S + 1.0 or STUCK_S[0] <= time_s < STUCK_S[1] else 1.0


def run_with_faults(shift_ns: int = 0, *, full: bool = True) -> Iterator[tuple[str, str, int, dict[str, Any]]]:
    """A straight run with a crash, a portion in which it is stuck, and one in which the operator drives."""
    x_m = 0.0
    for number in range(round(DURATION_S * 100) + 1):
        time_s, stamp_ns = number / 100, START + shift_ns + number * SECOND // 100
        header = {"stamp": {"sec": stamp_ns // SECOND, "nanosec": stamp_ns % SECOND}, "frame_id": "base_link"}
        spike = -40.0 if full and 0.0 <= time_s - CRASH_S < 0.02 else 0.2 * np.sin(37.0 * number)
        acceleration = {"x": float(spike), "y": 9.81, "z": 0.0}
        yield "/imu/data", "sensor_msgs/msg/Imu", stamp_ns, {"header": header, "linear_acceleration": acceleration}
        if number % 10:
            continue
        v_mps = speed_at(time_s) if full else 1.0
        pose = {"pose": {"position": {"x": x_m}, "orientation": {"w": 1.0}}}
        odometry = {"header": header, "child_frame_id": "base_link", "pose": pose}
        yield "/odom", "nav_msgs/msg/Odometry", stamp_ns, odometry | {"twist": {"twist": {"linear": {"x": v_mps}}}}
        x_m += 0.1 * v_mps
        if full:
            crashed = CRASH_S <= time_s < CRASH_S + 1.0
            command = {"linear": {"x": 0.0 if crashed else 1.0}}
            yield "/cmd_vel", "geometry_msgs/msg/Twist", stamp_ns, command
            active = OPERATOR_S[0] <= time_s < OPERATOR_S[1]
            yield "/manual_override", "std_msgs/msg/Bool", stamp_ns, {"data": active}


@pytest.fixture
def dataset(tmp_path: Path, tmp_path_factory: pytest.TempPathFactory, write_recording: Callable[..., Path]) -> Path:
    """Two runs: one with faults, one with odometry and IMU only that went well. Ingested once, copied to each test."""
    ingested = tmp_path_factory.getbasetemp() / "two_runs"
    if not ingested.exists():
        recordings = [
            write_recording("mcap", run_with_faults(), name="faults"),
            write_recording("mcap", run_with_faults(100 * SECOND, full=False), name="good"),
        ]
        report = ingest(recordings, ingested, RobotConfig(), IngestConfig())
        assert [episode.rows for episode in report.episodes] == [161, 161]
    shutil.copytree(ingested, tmp_path / "set")
    return tmp_path / "set"


def files(root: Path) -> dict[str, bytes]:
    return {
        path.relative_to(root).as_posix(): path.read_bytes()
        for path in sorted(root.rglob("*"))
        if path.is_file() and path.name != "lock"
    }


def labels(root: Path) -> dict[str, Any]:
    dataset = NavDataset(root)
    return {name: dataset.column(f"label.{name}") for name in ("outcome", "known", "reason", "confidence")}


def rows_of(reason: str, root: Path) -> list[int]:
    return [row for row, found in enumerate(labels(root)["reason"]) if found == reason]


def test_each_fault_is_labelled_at_its_rows_and_nothing_else(dataset: Path) -> None:
    report = label_dataset(dataset, LabelConfig())
    assert rows_of("collision", dataset) == list(range(50, 60))
    assert rows_of("stuck", dataset) == list(range(90, 120))
    assert rows_of("intervention", dataset) == list(range(140, 150))
    found = labels(dataset)
    np.testing.assert_array_equal(found["outcome"] == 0, found["reason"] != "")
    assert set(np.unique(found["confidence"][161:])) == {np.float32(0.8)}
    assert report.reasons == {"collision": 10, "stuck": 30, "intervention": 10}
    assert (report.episodes, report.rows, report.failed_rows, report.rewritten) == (2, 322, 50, [0, 1])
    assert report.notes == []


def test_what_a_rule_could_not_tell_is_reported_by_episode(dataset: Path) -> None:
    rules = label_dataset(dataset, LabelConfig(stuck=StuckConfig(enabled=False))).rules
    assert {name: (rule.episodes, rule.intervals, rule.not_applicable) for name, rule in rules.items()} == {
        "collision": (2, 1, {}),
        "stuck": (0, 0, {"switched off": [0, 1]}),
        "fall": (2, 0, {}),
        "intervention": (1, 1, {"no intervention stream": [1]}),
    }
    again = label_dataset(dataset, LabelConfig()).rules["stuck"]
    assert (again.episodes, again.not_applicable) == (1, {"no commands": [1]})


def test_known_steps_are_those_of_the_labelled_run(dataset: Path) -> None:
    report = label_dataset(dataset, LabelConfig())
    known = labels(dataset)["known"]
    good = np.arange(161)[:, None] + np.arange(10) < 161
    np.testing.assert_array_equal(known[161:], good)
    assert known[:41].all()
    assert known[45].all(), "the crash lies ahead on the predicted path: known to its end"
    assert known[60 - 3, 0]
    assert not known[57, 9], "it stands at row 57 and drives on at 60: what it would have met is not known"
    assert report.known_steps == int(known.sum())
    assert report.all_steps == known.size
    outcome = labels(dataset)["outcome"][:161]
    ahead = (np.arange(161)[:, None] + np.arange(10)).clip(max=160)
    assert report.negatives == int((known[:161] & (outcome[ahead] == 0)).any(axis=1).sum()) > 0


def test_an_odometry_at_odds_with_itself_is_noted(tmp_path: Path, write_recording: Callable[..., Path]) -> None:
    def faster() -> Iterator[tuple[str, str, int, dict[str, Any]]]:
        for topic, kind, stamp_ns, fields in run_with_faults(full=False):
            if topic == "/odom":
                fields["twist"] = {"twist": {"linear": {"x": 2.0}}}
            yield topic, kind, stamp_ns, fields

    robot = RobotConfig(odometry_twist=OdometryTwist.as_recorded)
    ingest([write_recording("mcap", faster(), name="odd")], tmp_path / "set", robot, IngestConfig())
    (note,) = label_dataset(tmp_path / "set", LabelConfig()).notes
    assert "/odd: by its poses the odometry drives 0.50 times as far as by its speeds" in note.text


def test_events_override_rules_and_count_seconds_from_the_start(dataset: Path, tmp_path: Path) -> None:
    events = tmp_path / "events.csv"
    events.write_text("bag,start,end,outcome,reason\nfaults,5,5.5,1,only a bump\ngood,2,2.3,0,wet grass\n")
    report = label_dataset(dataset, LabelConfig(), events)
    assert rows_of("only a bump", dataset) == list(range(50, 55))
    assert rows_of("collision", dataset) == list(range(55, 60))
    assert rows_of("wet grass", dataset) == [161 + row for row in (20, 21, 22)]
    found = labels(dataset)
    assert found["outcome"][50:55].all()
    assert not found["outcome"][181:184].any()
    assert (found["confidence"][181:184] == 1.0).all()
    assert report.events is not None
    assert (report.events.name, report.events.events, len(report.events.sha256)) == ("events.csv", 2, 64)
    faulty = tmp_path / "faulty.csv"
    faulty.write_text("bag,start,end,outcome,reason\nbad,2,2.3,0,wet grass\n")
    before = files(dataset)
    with pytest.raises(DatasetsError, match="unknown bag 'bad'"):
        label_dataset(dataset, LabelConfig(), faulty)
    assert files(dataset) == before


def test_only_the_label_columns_change_and_schema_and_row_groups_stay(dataset: Path) -> None:
    path = dataset / "data/chunk-000/file-000.parquet"
    before = pq.ParquetFile(path)
    columns, groups, schema = before.read(), before.metadata.num_row_groups, before.schema_arrow
    label_dataset(dataset, LabelConfig())
    after = pq.ParquetFile(path)
    assert after.schema_arrow.equals(schema, check_metadata=True)
    assert after.metadata.num_row_groups == groups
    for name in schema.names:
        assert after.read([name]).column(0).equals(columns.column(name)) == (not name.startswith("label.")), name
    metadata = after.metadata.row_group(0)
    assert {metadata.column(index).compression for index in range(metadata.num_columns)} == {"ZSTD"}


def test_relabelling_gives_identical_bytes_and_writes_no_data_file(dataset: Path) -> None:
    label_dataset(dataset, LabelConfig())
    first = files(dataset)
    inodes = {path: path.stat().st_ino for path in dataset.rglob("data/**/*.parquet")}
    assert label_dataset(dataset, LabelConfig()).rewritten == []
    assert files(dataset) == first
    assert {path: path.stat().st_ino for path in inodes} == inodes


def test_the_order_of_settings_leaves_no_trace(dataset: Path, tmp_path: Path) -> None:
    shutil.copytree(dataset, tmp_path / "other")
    label_dataset(tmp_path / "other", LabelConfig(collision=CollisionConfig(confidence=0.4)))
    for root in (dataset, tmp_path / "other"):
        label_dataset(root, LabelConfig())
    assert files(dataset) == files(tmp_path / "other")


def test_other_files_are_not_touched(dataset: Path) -> None:
    before = files(dataset)
    label_dataset(dataset, LabelConfig())
    after = files(dataset)
    changed = {name for name in after if after[name] != before.get(name)}
    assert changed == {
        *(f"data/chunk-000/file-00{number}.parquet" for number in (0, 1)),
        *(f"meta/episodes/chunk-000/file-00{number}.parquet" for number in (0, 1)),
        "meta/stats.json",
        "navtool/labels.json",
    }
    assert set(before) <= set(after)


def test_statistics_follow_the_labels(dataset: Path) -> None:
    label_dataset(dataset, LabelConfig())
    found = labels(dataset)
    total = json.loads((dataset / "meta/stats.json").read_text())
    for key in ("outcome", "known", "confidence"):
        values = found[key].astype(np.float64).reshape(322, -1)
        np.testing.assert_allclose(total[f"label.{key}"]["mean"], values.mean(axis=0), atol=1e-6)
        np.testing.assert_allclose(total[f"label.{key}"]["min"], values.min(axis=0), atol=1e-6)
        assert total[f"label.{key}"]["count"] == [322]
    entry = pq.read_table(dataset / "meta/episodes/chunk-000/file-000.parquet").to_pylist()[0]
    np.testing.assert_allclose(entry["stats/label.outcome/mean"], [found["outcome"][:161].mean()])
    assert entry["stats/label.outcome/count"] == [161]
    assert entry["length"] == 161


def test_the_summary_names_settings_events_rules_and_code(dataset: Path) -> None:
    report = label_dataset(dataset, LabelConfig(success_confidence=0.5))
    told = json.loads((dataset / "navtool/labels.json").read_text())
    assert told["schema_version"] == 1
    assert told["config"]["success_confidence"] == 0.5
    assert told["events"] is None
    assert told["reasons"] == report.reasons
    assert told["rules"]["intervention"]["not_applicable"] == {"no intervention stream": [1]}
    assert {"config_hash", "code_version", "failed_rows", "negatives", "known_steps"} <= set(told)
    assert NavDataset(dataset).lineage()["labels"] == told
    assert json.loads(json.dumps(report.to_json(), allow_nan=False))["rewritten"] == [0, 1]


def without_code_version(content: dict[str, bytes]) -> dict[str, Any]:
    """The files, but for the hash of the sources: they may be edited while the test runs."""
    told = json.loads(content.get("navtool/labels.json", b"{}"))
    return content | {"navtool/labels.json": {key: value for key, value in told.items() if key != "code_version"}}


@pytest.mark.parametrize(("stage", "at"), [pytest.param("write", 3, marks=pytest.mark.slow), ("replace", 3)])
def test_a_killed_run_leaves_all_old_or_all_new_labels(dataset: Path, tmp_path: Path, stage: str, at: int) -> None:
    shutil.copytree(dataset, tmp_path / "whole")
    label_dataset(tmp_path / "whole", LabelConfig())
    before, whole = files(dataset), files(tmp_path / "whole")
    command = [sys.executable, "-c", LABEL_AND_DIE, str(dataset), stage, str(at)]
    assert subprocess.run(command, check=False).returncode == KILLED  # noqa: S603 - our own interpreter and text
    assert recover(dataset) == (stage == "replace")
    kept = {name: content for name, content in files(dataset).items() if not name.endswith(".new")}
    assert without_code_version(kept) == without_code_version(whole if stage == "replace" else before)
    label_dataset(dataset, LabelConfig())
    assert files(dataset) == whole


def test_a_failure_before_the_step_takes_the_new_files_away(dataset: Path) -> None:
    before = files(dataset)

    class Interrupted(Silent):
        def done(self, things: int, name: str) -> None:
            raise KeyboardInterrupt(things, name)

    with pytest.raises(KeyboardInterrupt):
        label_dataset(dataset, LabelConfig(), progress=Interrupted())
    assert files(dataset) == before


def test_a_failure_within_the_step_completes_it(dataset: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(done: int) -> None:
        if done == 2:
            raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr("navtool.datasets.labels.apply.commit", lambda root, targets: journal.commit(root, targets, fail))
        with pytest.raises(KeyboardInterrupt):
            label_dataset(dataset, LabelConfig())
    assert not journal_path(dataset).exists()
    assert label_dataset(dataset, LabelConfig()).rewritten == []


def test_what_is_no_data_set_or_cannot_be_read_is_refused(dataset: Path, tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    for folder in ("absent", "empty"):
        with pytest.raises(DatasetsError):
            label_dataset(tmp_path / folder, LabelConfig())
    assert list((tmp_path / "empty").iterdir()) == []
    assert not (tmp_path / "absent").exists()
    data = dataset / "data/chunk-000/file-001.parquet"
    os.truncate(data, data.stat().st_size // 2)
    before = files(dataset)
    with pytest.raises(DatasetsError, match="file-001"):
        label_dataset(dataset, LabelConfig())
    assert files(dataset) == before


def test_progress_adds_up_whether_labels_change_or_not(dataset: Path) -> None:
    first, again = Counted(), Counted()
    report: LabelReport = label_dataset(dataset, LabelConfig(), progress=first)
    assert report.rewritten == [0, 1]
    assert (first.begun, first.worked, first.spared) == ((2, 4), 4, 0)
    assert [things for things, _ in first.finished] == [1, 2]
    label_dataset(dataset, LabelConfig(), progress=again)
    assert (again.begun, again.worked, again.spared) == ((2, 4), 2, 2)
