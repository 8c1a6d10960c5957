"""Reading a data set back without lerobot or torch: columns whole, clouds and frames one at a time."""

from collections import OrderedDict
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import av
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from jaxtyping import Float32, Int64, Shaped, UInt8

from navtool.base.errors import DatasetsError
from navtool.base.files import read_json
from navtool.datasets.robot.calibration import Calibration, read_calibration
from navtool.datasets.store.description import read_description
from navtool.datasets.store.journal import recover
from navtool.datasets.store.layout import Layout
from navtool.datasets.store.reading import REBUILD, reading
from navtool.datasets.store.row_points import of_fixed_size, points_part, read_points
from navtool.datasets.store.schema import arrow_schema, features_of, video_keys
from navtool.datasets.store.whole_clouds import WholeCloud, WholeClouds, read_whole_clouds, whole_cloud_stamps
from navtool.datasets.streams.table import FRONT, SMALL
from navtool.pipeline.arrays import Array

_OPEN_FILES = 32
"""Open files of rows and points, and videos, that a reader keeps."""


@dataclass(frozen=True, slots=True)
class Episode:
    """One run: rows ``start`` to ``stop`` (exclusive), the recording and the place it came from."""

    index: int
    start: int
    stop: int
    source: str
    place: str
    """Empty where it was not given."""

    def __len__(self) -> int:
        """Number of rows."""
        return self.stop - self.start


class NavDataset:
    """A data set that ``navtool ingest`` wrote, for reading.

    Opening reads metadata only. It may be opened in several processes; one object belongs to one process at a time,
    and pickles as its path.
    """

    def __init__(self, root: Path | str, *, verify: bool = False) -> None:
        """Open it.

        Args:
            root: The folder that `navtool ingest --out` wrote.
            verify: Whether the checksums of the Parquet files' pages are compared whenever they are read.

        Raises:
            DatasetsError: If there is no data set of this schema version here, or its metadata is damaged.
        """
        root = Path(root)
        recover(root)
        self.root = root
        self._verify = verify
        self.description = read_description(root)
        self.layout = Layout(root)
        self.fps = self.description.fps
        self.features = features_of(self.description.contents)
        self._schema = arrow_schema(self.features)
        self.episodes = self._read_episodes()
        self._columns: dict[str, Shaped[Array, " rows *shape"]] = {}
        self._files: OrderedDict[Path, pq.ParquetFile] = OrderedDict()
        self._videos: OrderedDict[tuple[int, str], _Video] = OrderedDict()
        self._videos_of = video_keys(self.features)
        self._calibrations: dict[int, Calibration] = {}
        self._whole: dict[int, WholeClouds] = {}

    def __reduce__(self) -> tuple[type["NavDataset"], tuple[Path]]:
        return (NavDataset, (self.root,))

    def __len__(self) -> int:
        """Number of rows over all episodes."""
        return self.episodes[-1].stop

    def column(self, name: str) -> Shaped[Array, " rows *shape"]:
        """A column over all rows, kept in memory; read-only. Clouds and images are read one at a time instead.

        Raises:
            DatasetsError: If there is no such column, or a file is damaged.
        """
        if name not in self._columns:
            if name not in self.features or name in self._videos_of:
                known = ", ".join(key for key in self.features if key not in self._videos_of)
                raise DatasetsError(f"has no column {name!r}", where=self.root, cure=f"known are {known}")
            parts = [self._read_column(episode, name) for episode in self.episodes]
            column = np.concatenate(parts)
            column.flags.writeable = False
            self._columns[name] = column
        return self._columns[name]

    def points(self, row: int) -> Float32[Array, "10000 3"]:
        """The cloud of a row in metres in the base frame; beyond ``lidar.count`` its points repeat.

        Raises:
            DatasetsError: If the data set has no clouds, or the file is damaged.
            IndexError: If there is no such row.
        """
        return of_fixed_size(self.distinct_points(row))

    def distinct_points(self, row: int) -> Float32[Array, "n 3"]:
        """The cloud of a row as `points` gives it, without repetitions.

        Raises:
            DatasetsError: As `points`.
            IndexError: Likewise.
        """
        episode = self.episode_of(row)
        if not self.description.contents.lidar:
            raise DatasetsError("has no point clouds", where=self.root, cure="ingest recordings that have some")
        folder = self.layout.points(episode.index)
        # Every part but the last has as many rows as the first.
        part, within = divmod(row - episode.start, self._file(points_part(folder, 0)).num_row_groups)
        path = points_part(folder, part)
        with reading(path):
            return read_points(self._file(path), within)

    def image(self, row: int, camera: str = FRONT) -> UInt8[Array, "240 320 3"]:
        """The image of a row in RGB; black where ``valid.camera``, or that of the further camera, is false.

        Raises:
            DatasetsError: If the data set has no such camera, or the video is damaged.
            IndexError: If there is no such row.
        """
        episode = self.episode_of(row)
        key = f"observation.images.{camera}"
        if key not in self.features:
            raise self._no_camera(camera)
        path = self.layout.video(episode.index, key)
        opened = episode.index, key
        with reading(path):
            video = self._videos.pop(opened, None) or _Video(path)
            self._videos[opened] = video
            _evict(self._videos)
            return video.frame(row - episode.start, self.fps)

    def _no_camera(self, camera: str) -> DatasetsError:
        cameras = [key.rpartition(".")[2] for key in video_keys(self.features)]
        if not cameras:
            return DatasetsError("has no camera", where=self.root, cure="ingest recordings that have one")
        return DatasetsError(f"has no camera {camera!r}", where=self.root, cure=f"known are {', '.join(cameras)}")

    def episode_of(self, row: int) -> Episode:
        """The episode that a row belongs to.

        Raises:
            IndexError: If there is no such row.
        """
        if not 0 <= row < len(self):
            raise IndexError(f"row {row} of a data set with {len(self)} rows")
        starts = [episode.start for episode in self.episodes]
        return self.episodes[int(np.searchsorted(starts, row, side="right")) - 1]

    def calibration(self, episode: int) -> Calibration:
        """The geometry of an episode's robot.

        Raises:
            IndexError: If there is no such episode.
        """
        self._check_episode(episode)
        if episode not in self._calibrations:
            self._calibrations[episode] = read_calibration(self.layout.episode(episode) / "calibration.json")
        return self._calibrations[episode]

    def stream(self, episode: int, name: str) -> dict[str, Shaped[Array, " samples"]] | None:
        """An episode's stream at its native rate, by column (``stamp_ns``, ``record_ns``, values); None if absent.

        Raises:
            DatasetsError: If there is no stream of this name at all, or the file is damaged.
            IndexError: If there is no such episode.
        """
        self._check_episode(episode)
        if name not in SMALL:
            raise DatasetsError(f"no stream is called {name!r}", where=self.root, cure=f"use {', '.join(SMALL)}")
        path = self.layout.episode(episode) / "streams" / f"{name}.parquet"
        if not path.is_file():
            return None
        with reading(path):
            table = pq.read_table(path)
        return {name: table.column(name).to_numpy() for name in table.column_names}

    def clouds(self, episode: int, lidar: str | None = None) -> Iterator[WholeCloud]:
        """An episode's clouds as they were recorded, one after the other; none where it has no LiDAR.

        Args:
            episode: Its number.
            lidar: A further LiDAR's name; None is the first one.

        Raises:
            DatasetsError: While iterating: a file is damaged, or the data set has no such LiDAR.
            IndexError: While iterating: there is no such episode.
        """
        folder = self._clouds_folder(episode, lidar)
        with reading(folder):
            yield from read_whole_clouds(folder, verify=self._verify)

    def whole_cloud(self, row: int) -> WholeCloud | None:
        """The first LiDAR's cloud that a row was made from, with all its points; None where it has none.

        Raises:
            DatasetsError: A file is damaged.
            IndexError: If there is no such row.
        """
        episode = self.episode_of(row)
        if not self.description.contents.lidar or not self.column("valid.lidar")[row]:
            return None
        folder = self.layout.clouds(episode.index)
        with reading(folder):
            if episode.index not in self._whole:
                self._whole[episode.index] = WholeClouds(folder)
            return self._whole[episode.index].of_row(row - episode.start)

    def cloud_stamps(self, episode: int, lidar: str | None = None) -> Int64[Array, " clouds"]:
        """The times of an episode's whole clouds, in the order in which ``clouds`` gives them.

        Raises:
            DatasetsError: A file is damaged, or the data set has no such LiDAR.
            IndexError: If there is no such episode.
        """
        folder = self._clouds_folder(episode, lidar)
        with reading(folder):
            return whole_cloud_stamps(folder)

    def _clouds_folder(self, episode: int, lidar: str | None) -> Path:
        self._check_episode(episode)
        lidars = self.description.contents.lidars
        if lidar is not None and lidar not in lidars:
            cure = f"known are {', '.join(lidars)}" if lidars else "leave it out for the first one"
            raise DatasetsError(f"has no further LiDAR {lidar!r}", where=self.root, cure=cure)
        return self.layout.clouds(episode, lidar)

    def _check_episode(self, episode: int) -> None:
        if not 0 <= episode < len(self.episodes):
            raise IndexError(f"episode {episode} of a data set with {len(self.episodes)}")

    def lineage(self) -> dict[str, Any]:
        """What the data set was made from: recordings with hashes, settings, code."""
        provenance = self.provenance()
        return {
            "config_hash": self.description.config_hash,
            "code_version": sorted({str(entry["code_version"]) for entry in provenance}),
            "recordings": [{key: entry[key] for key in ("source", "sha256", "place")} for entry in provenance],
            "labels": read_json(self.layout.beside / "labels.json", REBUILD)
            if (self.layout.beside / "labels.json").is_file()
            else None,
        }

    def provenance(self) -> list[dict[str, Any]]:
        """What each episode was made from, as `provenance_of` has it."""
        return [self.provenance_of(episode.index) for episode in self.episodes]

    def provenance_of(self, episode: int) -> dict[str, Any]:
        """What an episode was made from: its recording, place, times, topics, what was recovered."""
        return read_json(self.layout.episode(episode) / "provenance.json", REBUILD)

    def _read_episodes(self) -> tuple[Episode, ...]:
        info = read_json(self.layout.info, REBUILD)
        total = info.get("total_episodes")
        if not isinstance(total, int) or total < 1:
            raise DatasetsError(f"counts {total} episodes", where=self.layout.info, cure=REBUILD)
        episodes = []
        for number in range(total):
            path = self.layout.episode_meta(number)
            with reading(path):
                entry = pq.read_table(path, columns=["dataset_from_index", "dataset_to_index"]).to_pylist()[0]
            made = self.provenance_of(number)
            start, stop = int(entry["dataset_from_index"]), int(entry["dataset_to_index"])
            episodes.append(Episode(number, start, stop, str(made["source"]), str(made["place"])))
        return tuple(episodes)

    def _read_column(self, episode: Episode, name: str) -> Shaped[Array, " rows *shape"]:
        path = self.layout.data(episode.index)
        with reading(path):
            table = self._file(path).read(columns=[name], use_threads=False)
            if not table.schema.equals(pa.schema([self._schema.field(name)])):
                raise DatasetsError(f"{name} has another type than the schema's", where=path, cure=REBUILD)
            if table.num_rows != len(episode):
                what = f"{table.num_rows} rows instead of {len(episode)}"
                raise DatasetsError(what, where=path, cure=REBUILD)
            column = table.column(0).combine_chunks()
        if pa.types.is_fixed_size_list(column.type) or pa.types.is_list(column.type):
            rows: Array = column.flatten().to_numpy(zero_copy_only=False).reshape(len(column), -1)
            return rows
        values: Array = column.to_numpy(zero_copy_only=False)
        # A vector of one named element, as of a robot with a battery and no joints, stays a vector.
        return values if self.features[name].names is None else values.reshape(-1, 1)

    def _file(self, path: Path) -> pq.ParquetFile:
        with reading(path):
            file = self._files.pop(path, None) or pq.ParquetFile(
                path, memory_map=True, page_checksum_verification=self._verify
            )
        self._files[path] = file
        _evict(self._files)
        return file


class _Video:
    """An open video; reading forward decodes on, any other frame seeks to the key frame before it."""

    def __init__(self, path: Path) -> None:
        self._container = av.open(str(path))
        self._stream = self._container.streams.video[0]
        self._stream.thread_type = "SLICE"
        self._frames: Iterator[av.VideoFrame] = iter(())
        self._next: int | None = None

    def frame(self, number: int, fps: int) -> UInt8[Array, "height width 3"]:
        if self._next is None or not 0 <= number - self._next <= 1:
            time_base = self._stream.time_base
            if time_base is None:
                raise ValueError("the video has no time base")
            self._container.seek(round(number / fps / time_base), stream=self._stream, backward=True, any_frame=False)
            self._frames = self._container.decode(self._stream)
        for frame in self._frames:
            if frame.time is None:
                raise ValueError("a frame has no time")
            self._next = round(frame.time * fps) + 1
            if self._next > number:
                return frame.to_ndarray(format="rgb24")
        raise ValueError(f"the video ends before frame {number}")

    def close(self) -> None:
        self._container.close()


def _evict(opened: OrderedDict[Path, pq.ParquetFile] | OrderedDict[tuple[int, str], _Video]) -> None:
    if len(opened) > _OPEN_FILES:
        _, oldest = opened.popitem(last=False)
        oldest.close()
