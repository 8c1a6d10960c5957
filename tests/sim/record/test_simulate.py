"""Many episodes: the same bytes however they are made, and only whole recordings of one configuration in a folder."""

import fcntl
import itertools
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from hashes import hashes

from navtool.base.errors import DatasetsError
from navtool.datasets.recording.identity import recording_sha256
from navtool.sim.drive.config import DriveConfig, PoseConfig
from navtool.sim.errors import SimError
from navtool.sim.record.bag_format import BagFormat
from navtool.sim.record.config import SimulationConfig
from navtool.sim.record.episode import plan_episode
from navtool.sim.record.recorder_config import CameraSetup, RecorderConfig
from navtool.sim.record.recordings import LINEAGE
from navtool.sim.record.simulate import simulate
from navtool.sim.record.stage import Stage
from navtool.sim.world.scenario import ScenarioConfig, Split

Configure = Callable[..., SimulationConfig]


@pytest.fixture(scope="module")
def whole(tiny: Configure, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three episodes, made in one go by one worker."""
    root = tmp_path_factory.mktemp("whole") / "out"
    report = simulate(tiny(), root, 3)
    assert [episode.plan.number for episode in report.episodes] == [0, 1, 2]
    assert not report.skipped
    assert not report.not_made
    return root


def test_a_place_has_a_folder_and_lineage_says_what_each_was_made_from(whole: Path, tiny: Configure) -> None:
    report = simulate(tiny(), whole, 3)
    assert report.skipped == [0, 1, 2]
    assert sorted(hashes(whole)) == [
        LINEAGE,
        *(f"yard-test-0/run-{number}.mcap" for number in range(3)),
    ]


def test_two_workers_make_the_same_bytes(whole: Path, tiny: Configure, tmp_path: Path) -> None:
    told: list[tuple[str, int]] = []

    class Told:
        def begin(self, _things: int, work: int) -> None:
            told.append(("begin", work))

        def advance(self, done: int, spared: int) -> None:
            told.append(("advance", done))
            assert spared == 0

        def done(self, things: int, name: str) -> None:
            told.append((name, things))

    report = simulate(tiny(), tmp_path / "out", 3, workers=2, progress=Told())
    assert hashes(tmp_path / "out") == hashes(whole)
    assert sorted(count for name, count in told if name.startswith("yard")) == [1, 2, 3]
    (work,) = (count for name, count in told if name == "begin")
    assert sum(count for name, count in told if name == "advance") == work > 0
    assert report.pictures_per_s > 0
    assert report.peak_rss_mib > 0


def test_what_is_missing_is_made_again_with_the_same_bytes(whole: Path, tiny: Configure, tmp_path: Path) -> None:
    root = tmp_path / "out"
    simulate(tiny(), root, 1)
    (root / ".unfinished" / "episode-1").mkdir(parents=True)  # as a killed run leaves it
    (root / ".unfinished" / "episode-1" / "half").write_bytes(b"torn")
    assert [episode.plan.number for episode in simulate(tiny(), root, 3).episodes] == [1, 2]
    assert hashes(root) == hashes(whole)
    (root / "yard-test-0" / "run-1.mcap").unlink()
    (root / "yard-test-0" / "run-0.mcap").write_bytes(b"torn")
    assert [episode.plan.number for episode in simulate(tiny(), root, 3).episodes] == [0, 1]
    assert hashes(root) == hashes(whole)


def test_a_recording_that_lineage_does_not_know_yet_is_made_again(whole: Path, tiny: Configure, tmp_path: Path) -> None:
    root = tmp_path / "out"
    simulate(tiny(), root, 1)
    shutil.copy(whole / "yard-test-0" / "run-1.mcap", root / "yard-test-0")  # moved in place, then the run was killed
    assert [episode.plan.number for episode in simulate(tiny(), root, 2).episodes] == [1]
    path = "yard-test-0/run-1.mcap"
    assert hashes(root)[path] == hashes(whole)[path]


@pytest.mark.parametrize("kind", [BagFormat.db3, BagFormat.ros1], ids=lambda kind: kind.name)
def test_other_formats_resume_too(kind: BagFormat, tiny: Configure, tmp_path: Path) -> None:
    config = tiny(format=kind)
    (made,) = simulate(config, tmp_path / "a", 1).episodes
    path = tmp_path / "a" / made.plan.path
    assert recording_sha256(path) == (made.sha256, made.size_bytes)
    assert simulate(config, tmp_path / "a", 1).skipped == [0]
    (again,) = simulate(config, tmp_path / "b", 1).episodes
    assert (again.sha256, again.failures) == (made.sha256, made.failures)


def test_other_settings_are_refused_and_named(whole: Path, tiny: Configure) -> None:
    before = hashes(whole)
    for config, seed, said in (
        (tiny(camera=CameraSetup(width=80, height=48)), 0, "camera.width (was 64, now 80)"),
        (tiny(recorder=RecorderConfig(delay=2.0)), 0, "recorder.delay (was 1.0, now 2.0)"),
        (tiny(), 1, "seed (was 0, now 1)"),
        (tiny(format=BagFormat.ros1), 0, "format (was mcap, now ros1)"),
    ):
        with pytest.raises(DatasetsError, match="made with another") as caught:
            simulate(config, whole, 3, seed)
        assert said in str(caught.value)
        assert "--out" in str(caught.value)
    assert hashes(whole) == before


def test_a_folder_with_something_else_is_left_alone(tiny: Configure, tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text("mine")
    with pytest.raises(DatasetsError, match="holds something else"):
        simulate(tiny(), tmp_path, 1)
    with pytest.raises(DatasetsError, match="is a file"):
        simulate(tiny(), tmp_path / "mine.txt", 1)
    (tmp_path / "mine.txt").rename(tmp_path / LINEAGE)
    with pytest.raises(DatasetsError, match="is not JSON"):
        simulate(tiny(), tmp_path, 1)
    assert (tmp_path / LINEAGE).read_text() == "mine"


def test_two_runs_do_not_write_at_once(tiny: Configure, tmp_path: Path) -> None:
    with (tmp_path / ".lock").open("w") as held:
        fcntl.flock(held, fcntl.LOCK_EX)
        with pytest.raises(DatasetsError, match="another process is writing"):
            simulate(tiny(), tmp_path, 1)


def test_an_episode_that_cannot_be_driven_is_reported(tiny: Configure, stage: Stage, tmp_path: Path) -> None:
    trunk = next(item for item in stage.world.obstacles.items if item.kind == "trunk")
    inside = DriveConfig(duration_s=1.5, start=PoseConfig(x_m=trunk.x_m, y_m=trunk.y_m))
    report = simulate(tiny(drive=inside), tmp_path / "out", 1)
    assert not report.episodes
    assert report.not_made[0].plan.number == 0
    assert "trunk" in report.not_made[0].reason
    assert not (tmp_path / "out").exists(), "a folder made in vain is taken away"


@pytest.mark.parametrize(("episodes", "seed", "workers"), [(0, 0, 1), (10_001, 0, 1), (1, -1, 1), (1, 0, 0)])
def test_arguments_out_of_range_are_refused(
    episodes: int, seed: int, workers: int, tiny: Configure, tmp_path: Path
) -> None:
    with pytest.raises(SimError, match="ask for"):
        simulate(tiny(), tmp_path / "out", episodes, seed, workers=workers)
    assert not (tmp_path / "out").exists()


def test_no_two_plans_share_a_recording_or_a_moment(tiny: Configure, place: ScenarioConfig) -> None:
    plans = [
        plan_episode(tiny(scenario=replace(place, split=split)), seed, number)
        for split, seed, number in itertools.product(Split, (0, 1, 100_000), (0, 1, 2, 9_999))
    ]
    assert len({plan.path for plan in plans}) == len(plans)
    assert len({plan.place for plan in plans}) == len(Split) * 3 * 2
    begins = sorted(plan.start_ns for plan in plans)
    assert min(b - a for a, b in itertools.pairwise(begins)) > 3600 * 10**9
    assert 0 < begins[0] < begins[-1] + 3600 * 10**9 < 2**31 * 10**9, "ROS 2 counts seconds in 32 bits"
