"""The labels of one episode, from its rows and native streams."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Shaped

from navtool.datasets.labels.config import LabelConfig
from navtool.datasets.labels.events import Event
from navtool.datasets.labels.intervals import label_rows
from navtool.datasets.labels.known import known_steps
from navtool.datasets.labels.rules import FlagSignal, ImuSignal, RuleResult, Signals, apply_rules
from navtool.datasets.labels.speed_ratio import speed_ratio
from navtool.datasets.store.reader import Episode, NavDataset
from navtool.datasets.store.schema import ACTION_KEY, HORIZON_STEPS, POSE_KEY, STAMP_KEY, STATE_KEY
from navtool.pipeline.arrays import Array


@dataclass(frozen=True, slots=True)
class EpisodeLabels:
    """The label columns of an episode, and what the rules said."""

    columns: dict[str, Shaped[Array, " rows *shape"]]
    rules: tuple[RuleResult, ...]
    speed_ratio: float | None
    """Distance by the poses over distance by the speeds; None where the robot hardly moves."""

    @property
    def reasons(self) -> dict[str, int]:
        """Rows by reason."""
        return dict(Counter(self.columns["label.reason"].tolist()))


def label_episode(dataset: NavDataset, episode: Episode, config: LabelConfig, events: Sequence[Event]) -> EpisodeLabels:
    """Apply rules and events to an episode; an event overrides rules, a more confident rule a less confident one.

    Args:
        dataset: The data set.
        episode: One of its episodes.
        config: Settings.
        events: The events of the episode's recording, in the order of their file.
    """
    signals = episode_signals(dataset, episode)
    rules = apply_rules(signals, config)
    found = sorted((entry for rule in rules for entry in rule.intervals), key=lambda entry: entry.confidence)
    manual = [event.interval(config.event_confidence) for event in events]
    labels = label_rows(signals.stamps_ns, signals.period_ns, [*found, *manual], config.success_confidence)
    pose = signals.pose[:, [0, 1, 5]]
    known = known_steps(
        pose,
        signals.state,
        signals.state_valid,
        dataset.fps,
        HORIZON_STEPS,
        config.max_deviation_m,
        labels.outcome,
    )
    columns = {
        "label.outcome": labels.outcome,
        "label.known": known,
        "label.reason": labels.reason,
        "label.confidence": labels.confidence,
    }
    return EpisodeLabels(columns, rules, speed_ratio(pose, signals.state, signals.state_valid, dataset.fps))


def episode_signals(dataset: NavDataset, episode: Episode) -> Signals:
    """What the rules look at, out of the data columns and the native streams."""
    rows = slice(episode.start, episode.stop)
    return Signals(
        stamps_ns=dataset.column(STAMP_KEY)[rows],
        state=dataset.column(STATE_KEY)[rows],
        action=dataset.column(ACTION_KEY)[rows],
        pose=dataset.column(POSE_KEY)[rows],
        state_valid=dataset.column("valid.state")[rows],
        action_valid=dataset.column("valid.action")[rows],
        period_ns=round(1e9 / dataset.fps),
        imu=_imu(dataset, episode),
        intervention=_intervention(dataset, episode),
    )


def _imu(dataset: NavDataset, episode: Episode) -> ImuSignal | None:
    stream = dataset.stream(episode.index, "imu")
    if stream is None:
        return None
    acceleration = np.column_stack([stream[name] for name in ("ax_mps2", "ay_mps2", "az_mps2")])
    finite = np.isfinite(acceleration).all(axis=1)
    return ImuSignal(stream["stamp_ns"][finite], acceleration[finite])


def _intervention(dataset: NavDataset, episode: Episode) -> FlagSignal | None:
    stream = dataset.stream(episode.index, "intervention")
    if stream is None:
        return None
    return FlagSignal(stream["stamp_ns"], stream["active"] > 0)
