from pathlib import Path

import numpy as np
import pytest

from navtool.sim.demo import FAILED_SHARE, LIGHTS, PLACES, plan_demo, write_demo_recordings
from navtool.sim.errors import SimError


def test_a_demo_covers_places_lights_successes_and_both_failures() -> None:
    takes = list(plan_demo(seed=0, episodes=6, seconds=22.0))
    assert {take.path.parent.name for take in takes} == set(PLACES)
    assert len({take.path for take in takes}) == len({take.config.start_ns for take in takes}) == 6
    low, high = FAILED_SHARE
    shares = [take.track.failed_share for take in takes]
    assert all(low <= share <= high for share in shares), "each has both"
    assert 0.1 < np.mean(shares) < 0.4
    assert {failure.reason for take in takes for failure in take.track.failures} == {"collision", "stuck"}
    assert len({take.config.exposure.brightness for take in takes}) == len(LIGHTS)


def test_equal_arguments_plan_the_same_demo() -> None:
    first, again, other = (next(plan_demo(seed, episodes=2, seconds=12.0)) for seed in (3, 3, 4))
    assert first.scene.things == again.scene.things
    assert (first.track.x_m == again.track.x_m).all()
    assert first.config == again.config
    assert first.scene.things != other.scene.things
    assert first.config.seed != other.config.seed


@pytest.mark.slow
def test_a_demo_is_written_place_by_place_with_progress(tmp_path: Path) -> None:
    progress: list[tuple[int, int]] = []
    paths = write_demo_recordings(tmp_path, 2, 1, 10.0, lambda done, total: progress.append((done, total)))
    assert [path.relative_to(tmp_path).as_posix() for path in paths] == ["place-a/run-1.mcap"]
    assert progress == [(1, 1)]
    assert [path for path in tmp_path.rglob("*") if path.is_file()] == paths


@pytest.mark.parametrize(
    ("seed", "episodes", "seconds"), [(-1, 6, 22.0), (0, 0, 22.0), (0, 6, 5.0), (0, 6, float("nan"))]
)
def test_a_demo_out_of_range_is_refused(tmp_path: Path, seed: int, episodes: int, seconds: float) -> None:
    with pytest.raises(SimError, match="need episodes"):
        write_demo_recordings(tmp_path, seed, episodes, seconds)
    assert list(tmp_path.iterdir()) == []
