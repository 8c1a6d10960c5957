"""What a method walks along: a recording or an episode of a data set that was named, and is opened once."""

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import override

from navtool.base.errors import DatasetsError
from navtool.base.lineage import code_version
from navtool.base.plain import plain
from navtool.datasets.recording import Recording, open_recording
from navtool.datasets.recording.identity import recording_sha256
from navtool.datasets.robot.config import RobotConfig
from navtool.datasets.store.layout import Layout
from navtool.datasets.store.reader import NavDataset
from navtool.datasets.streams.config import SyncConfig
from navtool.methods.along.episode_streams import EpisodeStreams
from navtool.methods.along.place_truth import PlaceTruth, recorded_truth
from navtool.methods.along.recorded_streams import RecordedStreams
from navtool.methods.along.streams import Streams


class EpisodeError(DatasetsError):
    """An episode was named that there is none of, or has to be named."""


@dataclass(frozen=True, slots=True)
class Input:
    """An input that was named, and how it is read."""

    path: Path
    """A recording, or the folder of a data set."""
    episode: int | None = None
    """Episode of a data set; None for a recording, or the only one."""
    robot: RobotConfig = field(default_factory=RobotConfig)
    """Whose recording it is. A data set knows its own."""
    merged: bool = False
    """Whether all bags in the folder are one recording."""
    sync: SyncConfig = field(default_factory=SyncConfig)
    """Which time of a recording's messages counts, as for ingest."""

    @property
    def is_dataset(self) -> bool:
        """Whether the path is a data set's."""
        layout = Layout(self.path)
        return layout.description.is_file() or layout.info.is_file()

    @contextmanager
    def open(self) -> Iterator["Source"]:
        """It, while it is open.

        Raises:
            EpisodeError: There is no such episode, it has to be chosen, or a recording has none.
            DatasetsError: It cannot be read.
        """
        if self.is_dataset:
            dataset = NavDataset(self.path)
            yield EpisodeSource(dataset, self._episode_of(len(dataset.episodes)))
            return
        if self.episode is not None:
            cure = "leave --episode out, or name a data set"
            raise EpisodeError("is a recording: it has no episodes", where=self.path, cure=cure)
        with open_recording(self.path, merged=self.merged) as recording:
            yield RecordingSource(recording, self)

    def _episode_of(self, count: int) -> int:
        episode = 0 if self.episode is None and count == 1 else self.episode
        if episode is None:
            what = f"the data set has {count} episodes"
            raise EpisodeError(what, where=self.path, cure=f"choose one of 0 to {count - 1} with --episode")
        if not 0 <= episode < count:
            what = f"there is no episode {episode}: the data set has {count}, counted from 0"
            raise EpisodeError(what, where=self.path, cure="choose one with --episode")
        return episode


class Source(ABC):
    """An input that is open. Opening reads no message."""

    path: Path
    """As it was named."""

    @abstractmethod
    def identity(self, settings: Mapping[str, object]) -> dict[str, object]:
        """What has to be equal for the same results: hashes of the input and of the code, and every setting.

        Args:
            settings: Everything that decides the results, beside the input and how it is read.

        Raises:
            DatasetsError: The input cannot be read.
        """

    @abstractmethod
    def about(self) -> dict[str, object]:
        """What else a lineage says of the input."""

    @abstractmethod
    def truth(self, odometry_gap_s: float) -> PlaceTruth | None:
        """What the input itself knows to stand there; None where it knows nothing."""

    @abstractmethod
    def streams(self, reads: Sequence[str], odometry_gap_s: float) -> Streams:
        """Its streams, as long as it is open.

        Args:
            reads: Names as in ``robot.topics``; the first has to be there.
            odometry_gap_s: Poses further apart than this are not interpolated between.

        Raises:
            DatasetsError: It cannot be read, or lacks the first of the streams.
        """


class RecordingSource(Source):
    """A recording that is open."""

    def __init__(self, recording: Recording, named: Input) -> None:
        self.path = named.path
        self._recording, self._named = recording, named

    def identity(self, settings: Mapping[str, object]) -> dict[str, object]:
        """The recording's hash, and all settings that decide how it is read."""
        sha256, _ = recording_sha256(self.path)
        read = {"robot": self._named.robot, "merged": self._named.merged, "sync": self._named.sync}
        return {"input": sha256, "settings": plain({**settings, **read}), "code_version": code_version()}

    def about(self) -> dict[str, object]:
        """Its path."""
        return {"recording": self.path.absolute().as_posix()}

    def truth(self, odometry_gap_s: float) -> PlaceTruth | None:
        """What a simulated recording has on its own topics."""
        return recorded_truth(self._recording, odometry_gap_s)

    def streams(self, reads: Sequence[str], odometry_gap_s: float) -> RecordedStreams:
        """Its streams; the recording is read once for them."""
        return RecordedStreams(self._recording, self._named.robot, self._named.sync, reads, odometry_gap_s)


class EpisodeSource(Source):
    """An episode of a data set that is open."""

    def __init__(self, dataset: NavDataset, episode: int) -> None:
        self.path = dataset.root
        self._dataset, self._episode = dataset, episode

    def identity(self, settings: Mapping[str, object]) -> dict[str, object]:
        """The hash of the recording that the episode was made from, and the settings with the data set's hash."""
        made = self._dataset.provenance_of(self._episode)
        read = {"dataset": self._dataset.description.config_hash}
        return {"input": made["sha256"], "settings": plain({**settings, **read}), "code_version": code_version()}

    def about(self) -> dict[str, object]:
        """The data set, the episode, and the recording that it was made from."""
        recording = self._dataset.lineage()["recordings"][self._episode]
        config = self._dataset.description.config_hash
        path = self.path.absolute().as_posix()
        return {"dataset": path, "episode": self._episode, "recording": recording, "dataset_config_sha256": config}

    @override
    def truth(self, odometry_gap_s: float) -> PlaceTruth | None:
        """Nothing: a data set does not hold what stands there."""
        return None

    def streams(self, reads: Sequence[str], odometry_gap_s: float) -> EpisodeStreams:
        """Its streams."""
        return EpisodeStreams(self._dataset, self._episode, reads, odometry_gap_s)
