"""The data set as a store of episodes: one writer at a time, an episode is in it whole or not at all."""

import fcntl
import json
import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from navtool.datasets.description import Description, read_description
from navtool.datasets.errors import DatasetsError, OutputError
from navtool.datasets.files import move, read_json, write_bytes, write_json
from navtool.datasets.ingest.episode import EpisodeFolder
from navtool.datasets.ingest.stats import Stats, aggregate
from navtool.datasets.journal import finish
from navtool.datasets.layout import DATA_PATH, FILES_PER_CHUNK, VIDEO_PATH, Layout
from navtool.datasets.schema import CODEBASE_VERSION, IMAGE_KEY, features_of

_REBUILD = "ingest the recordings again into another folder"


@contextmanager
def open_store(root: Path) -> Iterator["Store"]:
    """Lock a data set for writing, an existing or a new one, and clear away what an interrupted writer left.

    The kernel releases the lock with the process, however it ends.

    Raises:
        DatasetsError: If another process writes to it, or the folder holds something else.
    """
    layout = Layout(root)
    if root.exists() and not root.is_dir():
        raise DatasetsError("is a file", where=root, cure="name a folder for the data set")
    if root.is_dir() and any(root.iterdir()) and not layout.beside.is_dir():
        raise DatasetsError("the folder holds something else", where=root, cure="name an empty or a new folder")
    created = not root.exists()
    try:
        layout.beside.mkdir(parents=True, exist_ok=True)
        lock = layout.lock.open("w")
    except OSError as error:
        raise OutputError(f"cannot be written ({error.strerror})", where=root, cure="check its rights") from error
    with lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            cure = "wait until it is done, or ingest into another folder"
            raise DatasetsError("another process is writing to it", where=root, cure=cure) from error
        finish(root)
        store = Store(layout)
        store.clear()
        try:
            yield store
        finally:
            store.clear()
            if created and store.episodes == 0:
                shutil.rmtree(root)


class Store:
    """A locked data set."""

    def __init__(self, layout: Layout) -> None:
        self.layout = layout
        self.description: Description | None = None
        self.episodes = 0
        self.rows = 0
        self._stats: dict[str, Stats] = {}
        if layout.description.is_file():
            self.description = read_description(layout.root)
            info = read_json(layout.info, _REBUILD)
            self.episodes, self.rows = int(str(info["total_episodes"])), int(str(info["total_frames"]))
            stats: dict[str, Any] = read_json(layout.stats, _REBUILD)
            self._stats = stats

    def provenance(self) -> list[dict[str, Any]]:
        """What each episode was made from."""
        return [self.provenance_of(number) for number in range(self.episodes)]

    def provenance_of(self, episode: int) -> dict[str, Any]:
        """What one episode was made from."""
        return read_json(self.layout.episode(episode) / "provenance.json", _REBUILD)

    def clear(self) -> None:
        """Remove staged files, and files of episodes that never became part of the data set."""
        shutil.rmtree(self.layout.staging, ignore_errors=True)
        number = self.episodes
        while self._remove(number):
            number += 1

    def _remove(self, episode: int) -> bool:
        files = (self.layout.data(episode), self.layout.video(episode), self.layout.episode_meta(episode))
        folder = self.layout.episode(episode)
        there = folder.exists() or any(file.exists() for file in files)
        for file in files:
            file.unlink(missing_ok=True)
        if folder.exists():
            shutil.rmtree(folder)
        return there

    def commit(self, staged: EpisodeFolder, description: Description, provenance: Mapping[str, object]) -> None:
        """Make a staged episode the data set's next one. Until ``info.json`` counts it, it does not exist.

        Raises:
            OutputError: If a file cannot be written; the data set is then as it was.
        """
        number = staged.numbering.episode_index
        if number != self.episodes or staged.numbering.index_from != self.rows:
            raise ValueError(f"episode {number} does not follow the {self.episodes} that are there")
        write_json(staged.beside / "provenance.json", provenance)
        try:
            move(staged.data, self.layout.data(number))
            if description.contents.image:
                move(staged.video, self.layout.video(number))
            move(staged.beside, self.layout.episode(number))
        except OSError as error:
            self._remove(number)
            where = self.layout.root
            raise OutputError(f"cannot be written ({error.strerror})", where=where, cure="check the space") from error
        task = str(description.robot["task"])
        write_bytes(self.layout.episode_meta(number), _episode_entry(staged, description, task))
        self._stats = aggregate([self._stats, staged.stats]) if self._stats else dict(staged.stats)
        if self.description is None:
            write_bytes(self.layout.tasks, _task_table(task))
        write_json(self.layout.stats, self._stats)
        self.episodes, self.rows = number + 1, self.rows + staged.rows
        write_json(self.layout.info, _info(description, self.episodes, self.rows))
        if self.description is None:
            write_json(self.layout.description, description.to_json())
            self.description = description


def _info(description: Description, episodes: int, rows: int) -> dict[str, object]:
    features = features_of(description.contents)
    return {
        "codebase_version": CODEBASE_VERSION,
        "robot_type": description.robot["name"],
        "total_episodes": episodes,
        "total_frames": rows,
        "total_tasks": 1,
        "chunks_size": FILES_PER_CHUNK,
        "data_files_size_in_mb": 100,
        "video_files_size_in_mb": 200,
        "fps": description.fps,
        "splits": {"train": f"0:{episodes}"},
        "data_path": DATA_PATH,
        "video_path": VIDEO_PATH if description.contents.image else None,
        "features": {key: feature.to_json(description.fps) for key, feature in features.items()},
    }


def _episode_entry(staged: EpisodeFolder, description: Description, task: str) -> bytes:
    number, first = staged.numbering.episode_index, staged.numbering.index_from
    place = Layout.place(number)
    entry: dict[str, object] = {
        "episode_index": number,
        "tasks": [task],
        "length": staged.rows,
        "data/chunk_index": place["chunk_index"],
        "data/file_index": place["file_index"],
        "dataset_from_index": first,
        "dataset_to_index": first + staged.rows,
    }
    if description.contents.image:
        entry |= {
            f"videos/{IMAGE_KEY}/chunk_index": place["chunk_index"],
            f"videos/{IMAGE_KEY}/file_index": place["file_index"],
            f"videos/{IMAGE_KEY}/from_timestamp": 0.0,
            f"videos/{IMAGE_KEY}/to_timestamp": staged.rows / description.fps,
        }
    entry |= {f"stats/{key}/{name}": value for key, stats in staged.stats.items() for name, value in stats.items()}
    entry |= {"meta/episodes/chunk_index": place["chunk_index"], "meta/episodes/file_index": place["file_index"]}
    return _parquet(pa.Table.from_pylist([entry]))


def _task_table(task: str) -> bytes:
    """The tasks in the form in which pandas writes an index named ``task``, which LeRobot reads."""
    pandas = {
        "index_columns": ["task"],
        "column_indexes": [],
        "columns": [
            {
                "name": "task_index",
                "field_name": "task_index",
                "pandas_type": "int64",
                "numpy_type": "int64",
                "metadata": None,
            },
            {"name": "task", "field_name": "task", "pandas_type": "unicode", "numpy_type": "object", "metadata": None},
        ],
        "creator": {"library": "pyarrow", "version": pa.__version__},
        "pandas_version": "2.0.0",
    }
    table = pa.table({"task_index": pa.array([0], pa.int64()), "task": pa.array([task], pa.string())})
    return _parquet(table.replace_schema_metadata({"pandas": json.dumps(pandas)}))


def _parquet(table: pa.Table) -> bytes:
    sink = pa.BufferOutputStream()
    pq.write_table(table, sink)
    content: bytes = sink.getvalue().to_pybytes()
    return content
