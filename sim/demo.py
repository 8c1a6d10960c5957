"""The recordings of the demo: a few short drives in different places and lights, each with successes and failures."""

import logging
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

from navtool.sim.bags import TakeConfig, write_recording
from navtool.sim.errors import SimError
from navtool.sim.render import Exposure
from navtool.sim.scene import Scene, make_scene
from navtool.sim.track import Track, drive

logger = logging.getLogger(__name__)

REASONS = ("collision", "stuck")
PLACES = ("place-a", "place-b", "place-c")
LIGHTS = (
    Exposure(brightness=1.0, noise=1.5, shutter_s=0.004),
    Exposure(brightness=0.55, noise=2.5, shutter_s=0.012),
    Exposure(brightness=1.2, noise=1.0, shutter_s=0.003),
    Exposure(brightness=0.14, noise=4.0, shutter_s=0.033),
)
"""Noon, overcast, glaring sun, dusk."""
FAILED_SHARE = (0.05, 0.5)
"""Least and largest share of a demo drive that fails."""
_TRIES = 40
_RUNS = 1000
_PAUSE_NS = 600 * 10**9


class DemoTake(NamedTuple):
    """One planned recording of the demo."""

    path: Path
    """Where it goes, relative to the demo's folder: the place, then the run."""
    scene: Scene
    track: Track
    config: TakeConfig


def plan_demo(seed: int = 0, episodes: int = 6, seconds: float = 22.0) -> Iterator[DemoTake]:
    """Yield the recordings of a demo, planned but not written.

    Places take turns, so that ``episodes`` >= 3 covers all of them; light and the reason of failure vary too.

    Args:
        seed: Decides everything, together with episodes and seconds; at least 0.
        episodes: How many recordings, at least 1.
        seconds: Length of each, at least 10, so that a failure and its recovery fit.

    Raises:
        SimError: An argument is out of range, or a place allows no eventful drive.
    """
    if episodes < 1 or not seconds >= 10 or seed < 0:
        what = f"need episodes >= 1, seconds >= 10 and seed >= 0, got {episodes}, {seconds} s and {seed}"
        raise SimError(what, cure="ask for more")
    scenes: dict[str, Scene] = {}
    for episode in range(episodes):
        place = PLACES[episode % len(PLACES)]
        if place not in scenes:
            scenes[place] = make_scene(seed, place)
        run = seed * _RUNS + episode
        config = TakeConfig(seed=run, exposure=LIGHTS[episode % len(LIGHTS)])
        config.start_ns += episode * _PAUSE_NS
        path = Path(place) / f"run-{episode // len(PLACES) + 1}.mcap"
        wanted = REASONS[episode % len(REASONS)]
        yield DemoTake(path, scenes[place], _eventful_drive(scenes[place], place, run, seconds, wanted), config)


def write_demo_recordings(
    folder: Path,
    seed: int = 0,
    episodes: int = 6,
    seconds: float = 22.0,
    progress: Callable[[int, int], None] | None = None,
) -> list[Path]:
    """Write the MCAP recordings of ``plan_demo`` into a folder, ``place-a/run-1.mcap`` and so on.

    Guarantee: the bytes depend on seed, episodes and seconds alone.

    Args:
        folder: Where to write; made when absent.
        seed: As for ``plan_demo``.
        episodes: As for ``plan_demo``.
        seconds: As for ``plan_demo``.
        progress: Called with (done, episodes) after each recording.

    Returns:
        The paths of the recordings, sorted.

    Raises:
        SimError: An argument is out of range, a recording exists, or cannot be written.
    """
    paths = []
    for take in plan_demo(seed, episodes, seconds):
        paths.append(write_recording(folder / take.path, take.scene, take.track, take.config))
        logger.info("wrote %s, %.0f %% of it failing", paths[-1], 100 * take.track.failed_share)
        if progress is not None:
            progress(len(paths), episodes)
    return sorted(paths)


def _eventful_drive(scene: Scene, place: str, run: int, seconds: float, wanted: str) -> Track:
    """Return the first of some drives that fails for the wanted reason, but not most of the time."""
    low, high = FAILED_SHARE
    for attempt in range(_TRIES):
        track = drive(scene, run * _TRIES + attempt, seconds)
        reasons = {failure.reason for failure in track.failures}
        if wanted in reasons and low <= track.failed_share <= high:
            return track
    what = f"none of {_TRIES} drives of {seconds} s has a {wanted} and a failed share of {low} to {high}"
    raise SimError(what, where=place, cure="use another seed or longer drives")
