"""A data set in as few files as LeRobot's streaming reader needs: one of rows, and one video a camera."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from navtool.base.errors import DatasetsError
from navtool.base.files import parquet_bytes, write_bytes, write_json
from navtool.base.progress import Progress
from navtool.datasets.edit.new_data_set import EditReport, copy_file, counted, new_folder
from navtool.datasets.store.data_file import WRITER_OPTIONS
from navtool.datasets.store.layout import Layout
from navtool.datasets.store.metadata import info_of
from navtool.datasets.store.reader import NavDataset
from navtool.datasets.store.reading import REBUILD, reading
from navtool.datasets.store.rewrite import entry_table
from navtool.datasets.store.schema import arrow_schema, video_keys
from navtool.datasets.store.video import join_videos


def compact(dataset: NavDataset, out: Path, progress: Progress | None = None) -> EditReport:
    """LeRobot's part of a data set with all episodes in one file of rows and one video a camera.

    ``StreamingLeRobotDataset`` takes the number of a row for its place in its video, which holds only then. Nothing is
    encoded again. What lies beside the rows stays in the data set; this is a copy for reading.

    Raises:
        DatasetsError: Something is in the folder already, or a file is damaged.
        OutputError: It cannot be written.
    """
    count = counted(progress, len(dataset.episodes))
    with new_folder(out) as staging:
        layout = Layout(staging)
        layout.data(0).parent.mkdir(parents=True)
        with pq.ParquetWriter(layout.data(0), arrow_schema(dataset.features), **WRITER_OPTIONS) as writer:
            for episode in dataset.episodes:
                writer.write_table(_rows(dataset.layout.data(episode.index)).cast(writer.schema))
                count(episode.source)
        for key in video_keys(dataset.features):
            videos = [dataset.layout.video(episode.index, key) for episode in dataset.episodes]
            frames = join_videos(videos, layout.video(0, key), dataset.fps)
            _refuse_misfit(videos, frames, dataset)
        entries = pa.concat_tables([entry_table(entry) for entry in _entries(dataset)])
        write_bytes(layout.episode_meta(0), parquet_bytes(entries))
        copy_file(dataset.layout.tasks, layout.tasks)
        copy_file(dataset.layout.stats, layout.stats)
        write_json(layout.info, info_of(dataset.description, len(dataset.episodes), len(dataset)))
    return EditReport(str(out), len(dataset.episodes), len(dataset))


def _refuse_misfit(videos: Sequence[Path], frames: Sequence[int], dataset: NavDataset) -> None:
    """One frame too few or too many would give all rows behind it the pictures of others."""
    for video, found, episode in zip(videos, frames, dataset.episodes, strict=True):
        if found != len(episode):
            raise DatasetsError(f"{found} frames instead of {len(episode)}", where=video, cure=REBUILD)


def _rows(data: Path) -> pa.Table:
    with reading(data):
        return pq.read_table(data)


def _entries(dataset: NavDataset) -> Iterator[dict[str, object]]:
    """Each episode's entry, with its place in the files of all."""
    for episode in dataset.episodes:
        entry: dict[str, object] = pq.read_table(dataset.layout.episode_meta(episode.index)).to_pylist()[0]
        entry |= {key: 0 for key in entry if key.endswith(("/chunk_index", "/file_index"))}
        for key in video_keys(dataset.features):
            entry[f"videos/{key}/from_timestamp"] = episode.start / dataset.fps
            entry[f"videos/{key}/to_timestamp"] = episode.stop / dataset.fps
        yield entry
