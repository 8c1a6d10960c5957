"""Whether a run's intensities can carry maps, judged before anything is written."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float32

from navtool.base.errors import DatasetsError
from navtool.base.note import Note
from navtool.methods.along.method import Walked
from navtool.methods.along.streams import Streams
from navtool.methods.along.sweeps import Sweep
from navtool.methods.intensity_map.config import SensorMapConfig
from navtool.pipeline.arrays import Array
from navtool.pipeline.intensity_map.config import ObstacleConfig
from navtool.pipeline.intensity_map.intensity_check import judge_intensities

SIMULATED = "simulated"
"""Name of the preset that the threshold was measured with."""
FIRST = 10
"""Sweeps that are judged together."""
_MUCH = 0.5


def judged(intensity: Float32[Array, " p"], config: SensorMapConfig) -> str | None:
    """What is wrong with intensities; None if they can be used.

    Up to ``largest_intensity`` they may exceed the full scale of the map, as retroreflectors do: they count as R.
    """
    largest = float(intensity.max(initial=0.0))
    if largest > config.largest_intensity:
        what = f"the largest intensity is {largest:g} where the sensor {config.sensor!r} gives at most"
        return f"{what} {config.largest_intensity:g}"
    full_scale = config.map.layers.full_scale
    return judge_intensities(np.minimum(intensity, np.float32(full_scale)), full_scale)


def judge_first(first: Sequence[Sweep], streams: Streams, config: SensorMapConfig) -> list[Note]:
    """What a user should look at in the first sweeps of an input, judged together.

    Raises:
        DatasetsError: Their intensities cannot carry a map; what, why and the cure.
    """
    intensity = np.concatenate([sweep.intensity for sweep in first])
    fault = judged(intensity, config)
    if fault is not None:
        cure = "choose the preset of the recording's sensor with sensor=, or set map.layers.full_scale and "
        what = f"{fault} (the first {len(first)} clouds)"
        raise DatasetsError(what, where=_where(streams), cure=f"{cure}largest_intensity")
    return _notes(intensity, len(first), config)


def _notes(intensity: Float32[Array, " p"], clouds: int, config: SensorMapConfig) -> list[Note]:
    full_scale, threshold = config.map.layers.full_scale, config.map.obstacles.threshold
    what = f"intensities: of the first {clouds} clouds"
    beyond = float((intensity > full_scale).mean())
    share = float(intensity.max()) / full_scale
    which = f"is sensor={config.sensor} the right one?"
    if beyond > _MUCH:
        found = f"{what}, {beyond:.0%} are above full_scale = {full_scale:g}: {which}"
        return [Note("intensities.beyond-scale", found)]
    if share <= threshold:
        below = f"the largest is {share:.2f} R, below the threshold {threshold:g}: nothing will be solid"
        return [Note("intensities.below-threshold", f"{what}, {below}; {which}")]
    return []


def threshold_notes(config: SensorMapConfig) -> list[Note]:
    """What a user should know of a threshold that nobody has set."""
    threshold = config.map.obstacles.threshold
    if config.sensor == SIMULATED or threshold != ObstacleConfig().threshold:
        return []
    measured = f"the threshold {threshold:g} R was measured on the simulated sensor, not on {config.sensor!r}"
    return [Note("threshold.not-fitted", f"{measured}: fit it with `navtool fit intensity_threshold`")]


def nothing_mapped(streams: Streams, walked: Walked) -> DatasetsError:
    """What is wrong where no cloud gives a map."""
    counts = walked.unread + walked.skipped
    reasons = ", ".join(f"{count} {reason}" for reason, count in counts.items())
    if set(walked.unread) == {"without intensities"}:
        what = f"none of the {walked.ticks} clouds has intensities: their points have no such field"
        cure = "record the driver's cloud with intensities, or name another topic with robot.topics.lidar=[/topic]"
        return DatasetsError(what, where=_where(streams), cure=f"{cure}; of a data set, ingest that recording again")
    what = f"none of the {walked.ticks} clouds can be mapped: {reasons}"
    return DatasetsError(what, where=_where(streams), cure="look at the recording with `navtool inspect --report`")


def _where(streams: Streams) -> str:
    return f"{streams.name}: {streams.topics['lidar']}"
