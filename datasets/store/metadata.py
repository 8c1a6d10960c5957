"""LeRobot's metadata: the description of a data set, the entry of an episode, the table of tasks."""

import json

import numpy as np
import pyarrow as pa

from navtool.base.files import parquet_bytes
from navtool.datasets.store.arrow_arrays import number_array, text_array
from navtool.datasets.store.description import Description
from navtool.datasets.store.layout import DATA_PATH, FILES_PER_CHUNK, VIDEO_PATH, Layout
from navtool.datasets.store.rewrite import entry_table, stats_columns
from navtool.datasets.store.schema import CODEBASE_VERSION, features_of, video_keys
from navtool.datasets.store.staged_episode import EpisodeFolder


def info_of(description: Description, episodes: int, rows: int) -> dict[str, object]:
    """The content of ``meta/info.json``."""
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
        "video_path": VIDEO_PATH if video_keys(features) else None,
        "features": {key: feature.to_json(description.fps) for key, feature in features.items()},
    }


def episode_entry(staged: EpisodeFolder, description: Description, task: str) -> bytes:
    """The Parquet file that describes an episode: where its rows and frames lie, and its statistics."""
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
    for key in video_keys(features_of(description.contents)):
        entry |= {
            f"videos/{key}/chunk_index": place["chunk_index"],
            f"videos/{key}/file_index": place["file_index"],
            f"videos/{key}/from_timestamp": 0.0,
            f"videos/{key}/to_timestamp": staged.rows / description.fps,
        }
    entry |= stats_columns(staged.stats)
    entry |= {"meta/episodes/chunk_index": place["chunk_index"], "meta/episodes/file_index": place["file_index"]}
    return parquet_bytes(entry_table(entry))


def task_table(task: str) -> bytes:
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
    arrays = [number_array(np.array([0], dtype=np.int64)), text_array([task])]
    table = pa.Table.from_arrays(arrays, names=["task_index", "task"])
    return parquet_bytes(table.replace_schema_metadata({"pandas": json.dumps(pandas)}))
