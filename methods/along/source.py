"""What intensity maps are made of: a recording, or an episode of a data set."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from navtool.base.errors import DatasetsError
from navtool.base.lineage import code_version, config_hash
from navtool.datasets.recording import open_recording
from navtool.datasets.recording.identity import recording_sha256
from navtool.datasets.robot.config import RobotConfig
from navtool.datasets.store.layout import Layout
from navtool.datasets.store.reader import NavDataset
from navtool.methods.along.episode_sweeps import EpisodeSweeps
from navtool.methods.along.recorded_sweeps import RecordedSweeps
from navtool.methods.along.sweeps import SweepSource
from navtool.methods.intensity_map.config import SensorMapConfig


@dataclass(frozen=True, slots=True)
class MapInput:
    """An input that was named, and how it is read."""

    path: Path
    """A recording, or the folder of a data set."""
    episode: int | None = None
    """Of a data set; None for a recording, or the only one."""
    robot: RobotConfig | None = None
    """Whose recording it is; None for the generic one. A data set knows its own."""
    merged: bool = False
    """Whether all bags in the folder are one recording."""

    @property
    def is_dataset(self) -> bool:
        """Whether the path is a data set's."""
        layout = Layout(self.path)
        return layout.description.is_file() or layout.info.is_file()

    def episode_count(self) -> int | None:
        """How many episodes the data set has; None for a recording.

        Raises:
            DatasetsError: The data set cannot be read.
        """
        return len(NavDataset(self.path).episodes) if self.is_dataset else None

    def refuse_episode(self, count: int | None) -> None:
        """Do nothing where an episode is named that is there, or none has to be.

        Args:
            count: Of ``episode_count``.

        Raises:
            DatasetsError: There is no such episode, it has to be chosen, or a recording has none.
        """
        if count is not None:
            self._episode_of(count)
        elif self.episode is not None:
            cure = "leave --episode out, or name a data set"
            raise DatasetsError("is a recording: it has no episodes", where=self.path, cure=cure)

    def identity(self, config: SensorMapConfig) -> dict[str, object]:
        """What has to be equal for the same maps: hashes of the input, of the settings and of the code.

        Raises:
            DatasetsError: The input cannot be read, or there is no such episode.
        """
        robot = self.robot or RobotConfig()
        if self.is_dataset:
            dataset = NavDataset(self.path)
            made = dataset.provenance()[self._episode_of(len(dataset.episodes))]
            settings = config_hash({"map": config, "dataset": dataset.description.config_hash})
            return {"input": made["sha256"], "settings": settings, "code_version": code_version()}
        sha256, _ = recording_sha256(self.path)
        settings = config_hash({"map": config, "robot": robot, "merged": self.merged})
        return {"input": sha256, "settings": settings, "code_version": code_version()}

    def about(self) -> dict[str, object]:
        """What else a lineage tells of the input."""
        path = self.path.absolute().as_posix()
        if not self.is_dataset:
            return {"recording": path}
        dataset = NavDataset(self.path)
        episode = self._episode_of(len(dataset.episodes))
        recording = dataset.lineage()["recordings"][episode]
        config = dataset.description.config_hash
        return {"dataset": path, "episode": episode, "recording": recording, "dataset_config_sha256": config}

    @contextmanager
    def open(self, config: SensorMapConfig) -> Iterator[SweepSource]:
        """Its sweeps, while it is open.

        Raises:
            DatasetsError: It cannot be read, has no clouds, or there is no such episode.
        """
        if self.is_dataset:
            dataset = NavDataset(self.path)
            yield EpisodeSweeps(dataset, self._episode_of(len(dataset.episodes)), config.sweeps)
            return
        self.refuse_episode(None)
        with open_recording(self.path, merged=self.merged) as recording:
            yield RecordedSweeps(recording, self.robot or RobotConfig(), config.sweeps)

    def _episode_of(self, count: int) -> int:
        episode = 0 if self.episode is None and count == 1 else self.episode
        if episode is None:
            what = f"the data set has {count} episodes"
            raise DatasetsError(what, where=self.path, cure=f"choose one of 0 to {count - 1} with --episode")
        if not 0 <= episode < count:
            what = f"there is no episode {episode}: the data set has {count}, counted from 0"
            raise DatasetsError(what, where=self.path, cure="choose one with --episode")
        return episode
