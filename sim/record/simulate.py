"""Many episodes of a scenario: the orchestrator of simulation."""

import time
from collections import deque
from concurrent.futures import Future
from pathlib import Path

from navtool.base.lineage import code_version
from navtool.base.note import Note
from navtool.base.progress import Progress, Silent
from navtool.base.workers import Workers, make_workers, outcome
from navtool.sim.errors import SimError
from navtool.sim.record.config import SimulationConfig
from navtool.sim.record.episode import EPISODES_MOST, SEED_MOST, Episode, NotMade, make_episode, plan_episode
from navtool.sim.record.recordings import Recordings, open_recordings
from navtool.sim.record.report import SimulationReport


def simulate(
    config: SimulationConfig,
    out: Path,
    episodes: int,
    seed: int = 0,
    *,
    workers: int = 1,
    progress: Progress | None = None,
) -> SimulationReport:
    """Write the recordings of the first so many episodes of a configuration and seed, and what each was made from.

    Guarantees: an episode's bytes depend on the configuration, the seed and its number alone. A recording is there
    whole or not; whenever a run is ended, the same call goes on with what is missing, and also with more episodes.

    Args:
        config: Scenario, robot, drive, sensors and recorder.
        out: Folder of the recordings, a subfolder for each place; made where it is not there.
        episodes: How many, 1 to 10,000.
        seed: Of places, drives and noise, 0 to 100,000.
        workers: How many processes work at the same time.
        progress: Who wants to know how far it is.

    Raises:
        SimError: An argument is out of range, or a recording cannot be written.
        DatasetsError: The folder holds something else or recordings of other settings, or another process writes to it.
        OutputError: The folder cannot be written, or a worker process is gone.
    """
    if not 1 <= episodes <= EPISODES_MOST or not 0 <= seed <= SEED_MOST or workers < 1:
        what = f"{episodes} episodes with seed {seed} by {workers} workers"
        cure = f"ask for 1-{EPISODES_MOST} episodes, a seed of 0-{SEED_MOST} and 1 worker or more"
        raise SimError(what, cure=cure)
    started = time.monotonic()
    shown = progress if progress is not None else Silent()
    report = SimulationReport(str(out))
    with open_recordings(out, config, seed) as recordings:
        missing = deque(number for number in range(episodes) if number not in recordings.episodes)
        report.skipped = [number for number in range(episodes) if number in recordings.episodes]
        report.notes = _notes(recordings)
        shown.begin(len(missing), len(missing) * _work_of(config))
        with make_workers(min(workers, max(len(missing), 1)), shown.advance) as pool:
            _work(config, seed, missing, pool, min(workers, EPISODES_MOST), recordings, report, shown)
    report.episodes.sort(key=lambda episode: episode.plan.number)
    report.not_made.sort(key=lambda episode: episode.plan.number)
    report.seconds = time.monotonic() - started
    return report


def _work(
    config: SimulationConfig,
    seed: int,
    missing: deque[int],
    pool: Workers,
    at_once: int,
    recordings: Recordings,
    report: SimulationReport,
    progress: Progress,
) -> None:
    """Have the missing episodes made, and keep each as it is done."""
    running: set[Future[Episode | NotMade]] = set()
    while missing or running:
        while missing and len(running) < at_once:
            plan = plan_episode(config, seed, missing.popleft())
            running.add(pool.submit(_work_of(config), make_episode, config, plan, recordings.root, recordings.staging))
        finished = {future for future in running if future.done()}
        if not finished:
            pool.wait(running)
        for future in finished:
            made = outcome(future)
            if isinstance(made, NotMade):
                report.not_made.append(made)
            else:
                recordings.keep(made)
                report.episodes.append(made)
            progress.done(len(report.episodes) + len(report.not_made), made.plan.path)
        running -= finished
    pool.wait(running)


def _work_of(config: SimulationConfig) -> int:
    """Work of an episode: the microseconds of its drive."""
    return round(config.drive.duration_s * 1e6)


def _notes(recordings: Recordings) -> list[Note]:
    others = sum(episode.code != code_version() for episode in recordings.episodes.values())
    what = f"{others} recordings were made by another version of navtool and are kept"
    return [Note("recordings.other-version", what)] if others else []
