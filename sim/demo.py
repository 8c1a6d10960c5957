"""The recordings of the demo: a few short drives in different places and lights, each with successes and failures."""

from collections.abc import Callable
from pathlib import Path

from navtool.sim.bags import TakeConfig, write_recording
from navtool.sim.errors import SimError
from navtool.sim.render import Exposure
from navtool.sim.scene import Scene, make_scene
from navtool.sim.track import Track, drive

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
_PAUSE_NS = 600 * 10**9


def write_demo_recordings(
    folder: Path,
    seed: int = 0,
    episodes: int = 6,
    seconds: float = 22.0,
    progress: Callable[[int, int], None] | None = None,
) -> list[Path]:
    """Write MCAP recordings ``place-a/run-1.mcap`` and so on, and return their paths, sorted.

    Places take turns, so that ``episodes`` >= 3 covers all of them; reasons of failure and light vary from run to run.

    Args:
        folder: Where to write; made when absent.
        seed: Decides all bytes, together with episodes and seconds.
        episodes: How many recordings, at least 1.
        seconds: Length of each, at least 10, so that a failure and its recovery fit.
        progress: Called with (done, episodes) after each recording.

    Raises:
        SimError: An argument is out of range, a recording exists, or cannot be written.
    """
    if episodes < 1 or not seconds >= 10 or seed < 0:
        what = f"need episodes >= 1, seconds >= 10 and seed >= 0, got {episodes}, {seconds} s and {seed}"
        raise SimError(what, cure="ask for more")
    scenes: dict[str, Scene] = {}
    paths = []
    for episode in range(episodes):
        place = PLACES[episode % len(PLACES)]
        if place not in scenes:
            scenes[place] = make_scene(seed, place)
        track = _eventful_drive(scenes[place], place, seed * 1000 + episode, seconds)
        config = TakeConfig(seed=seed * 1000 + episode, exposure=LIGHTS[episode % len(LIGHTS)])
        config.start_ns += episode * _PAUSE_NS
        path = folder / place / f"run-{episode // len(PLACES) + 1}.mcap"
        paths.append(write_recording(path, scenes[place], track, config))
        if progress is not None:
            progress(episode + 1, episodes)
    return sorted(paths)


def _eventful_drive(scene: Scene, place: str, run: int, seconds: float) -> Track:
    """Return the first of some drives that has both successes and failures; runs take turns with the reasons."""
    wanted = ("collision", "stuck")[run % 2]
    low, high = FAILED_SHARE
    for attempt in range(_TRIES):
        track = drive(scene, run * _TRIES + attempt, seconds)
        reasons = {failure.reason for failure in track.failures}
        if wanted in reasons and low <= track.failed_share <= high:
            return track
    what = f"none of {_TRIES} drives of {seconds} s has a {wanted} and a failed share of {low} to {high}"
    raise SimError(what, where=place, cure="use another seed or longer drives")
