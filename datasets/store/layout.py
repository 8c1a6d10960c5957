"""Where everything lies in a data set."""

from dataclasses import dataclass
from pathlib import Path

from navtool.datasets.store.schema import IMAGE_KEY

FILES_PER_CHUNK = 1000
DATA_PATH = "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"
VIDEO_PATH = "videos/{video_key}/chunk-{chunk_index:03d}/file-{file_index:03d}.mp4"
EPISODES_PATH = "meta/episodes/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"


@dataclass(frozen=True, slots=True)
class Layout:
    """The paths of a data set: LeRobot's files, one of each kind an episode, and navtool's own beside them."""

    root: Path

    @staticmethod
    def place(episode: int) -> dict[str, int]:
        """Chunk and file number of an episode's files."""
        return {"chunk_index": episode // FILES_PER_CHUNK, "file_index": episode % FILES_PER_CHUNK}

    def data(self, episode: int) -> Path:
        """The episode's rows."""
        return self.root / DATA_PATH.format(**self.place(episode))

    def video(self, episode: int, key: str = IMAGE_KEY) -> Path:
        """The episode's images of a camera, by its column; of the front camera unless another is named."""
        return self.root / VIDEO_PATH.format(video_key=key, **self.place(episode))

    def videos(self, episode: int) -> list[Path]:
        """The episode's videos that are there, whichever cameras the data set has."""
        return sorted(self.root.glob(VIDEO_PATH.format(video_key="*", **self.place(episode))))

    def episode_meta(self, episode: int) -> Path:
        """The episode's entry and statistics."""
        return self.root / EPISODES_PATH.format(**self.place(episode))

    @property
    def info(self) -> Path:
        """LeRobot's description of the data set; written last, so that an episode counts when this says so."""
        return self.root / "meta" / "info.json"

    @property
    def stats(self) -> Path:
        """LeRobot's statistics over all episodes."""
        return self.root / "meta" / "stats.json"

    @property
    def tasks(self) -> Path:
        """LeRobot's table of tasks."""
        return self.root / "meta" / "tasks.parquet"

    @property
    def beside(self) -> Path:
        """Everything of navtool's that LeRobot's readers ignore."""
        return self.root / "navtool"

    @property
    def description(self) -> Path:
        """Schema version, contents and configuration of the data set."""
        return self.beside / "dataset.json"

    @property
    def lock(self) -> Path:
        """Held by the one writer."""
        return self.beside / "lock"

    @property
    def staging(self) -> Path:
        """Where an episode is written before it is part of the data set."""
        return self.beside / "staging"

    def episode(self, episode: int) -> Path:
        """Clouds, native streams, calibration, sync report and provenance of an episode."""
        return self.beside / "episodes" / f"episode-{episode:06d}"

    def points(self, episode: int) -> Path:
        """The folder of the clouds of the episode's rows."""
        return self.episode(episode) / "points"

    def clouds(self, episode: int, lidar: str | None = None) -> Path:
        """The episode's whole clouds; of the first LiDAR unless a further one is named."""
        folder = self.episode(episode) / "clouds"
        return folder if lidar is None else folder / lidar
