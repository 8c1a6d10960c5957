"""Is everything there, can it be opened, and do its counters count?"""

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from navtool.base.errors import DatasetsError
from navtool.base.files import read_json
from navtool.datasets.check.findings import Findings, Severity, first_line, name_of, short
from navtool.datasets.store.reader import NavDataset
from navtool.datasets.store.schema import STAMP_KEY, arrow_schema


def check_metadata(dataset: NavDataset) -> Findings:
    """LeRobot's metadata agree with the data set's own."""
    info = read_json(dataset.layout.info, "")
    where = "meta/info.json"
    if info.get("total_frames") != len(dataset):
        yield Severity.FAIL, where, f"counts {info.get('total_frames')} rows, the episodes have {len(dataset)}"
    if info.get("fps") != dataset.fps:
        yield Severity.FAIL, where, f"says {info.get('fps')} fps, navtool/dataset.json {dataset.fps}"
    listed = info.get("features")
    if listed != {key: feature.to_json(dataset.fps) for key, feature in dataset.features.items()}:
        gone = [key for key in dataset.features if key not in listed] if isinstance(listed, dict) else []
        lacks = f": {', '.join(gone)} are gone" if gone else ""
        yield Severity.FAIL, where, f"lists other columns than this schema version has{lacks}"
    stats = read_json(dataset.layout.stats, "")
    index = stats.get("index")
    if isinstance(index, dict) and index.get("count") != [len(dataset)]:
        yield Severity.FAIL, "meta/stats.json", f"counts {index.get('count')} rows instead of {len(dataset)}"
    lacking = [key for key, feature in dataset.features.items() if feature.dtype != "string" and key not in stats]
    if lacking:
        yield Severity.FAIL, "meta/stats.json", f"has no statistics of {', '.join(lacking)}"
    expected = 0
    for episode in dataset.episodes:
        if episode.start != expected or len(episode) < 1:
            yield Severity.FAIL, name_of(episode), f"rows {episode.start} to {episode.stop} do not follow {expected}"
        expected = episode.stop


def check_files(dataset: NavDataset) -> Findings:
    """Every file opens and has the rows and columns that it should."""
    try:
        pq.read_metadata(dataset.layout.tasks)
    except (OSError, pa.ArrowException) as error:
        yield Severity.FAIL, short(dataset, dataset.layout.tasks), f"cannot be opened: {first_line(error)}"
    schema = arrow_schema(dataset.features)
    for episode in dataset.episodes:
        path = dataset.layout.data(episode.index)
        try:
            file = pq.ParquetFile(path)
        except (OSError, pa.ArrowException) as error:
            yield Severity.FAIL, short(dataset, path), f"cannot be opened: {first_line(error)}"
            continue
        with file:
            if file.metadata.num_rows != len(episode):
                yield Severity.FAIL, short(dataset, path), f"{file.metadata.num_rows} rows instead of {len(episode)}"
            if not file.schema_arrow.remove_metadata().equals(schema.remove_metadata()):
                yield Severity.FAIL, short(dataset, path), "columns differ from the schema's"
        beside = dataset.layout.episode(episode.index)
        for extra in sorted(beside.rglob("*.parquet")):
            try:
                pq.read_metadata(extra)
            except (OSError, pa.ArrowException) as error:
                yield Severity.FAIL, short(dataset, extra), f"cannot be opened: {first_line(error)}"
        for name in ("provenance.json", "calibration.json", "sync.json"):
            try:
                read_json(beside / name, "")
            except DatasetsError as error:
                yield Severity.FAIL, short(dataset, beside / name), error.what


def check_counters(dataset: NavDataset) -> Findings:
    """Rows, frames and episodes are counted without a gap, and the true stamps lie on the grid."""
    index = dataset.column("index")
    if not np.array_equal(index, np.arange(len(dataset))):
        yield Severity.FAIL, "index", "does not count the rows"
    stamps, seconds = dataset.column(STAMP_KEY), dataset.column("timestamp")
    frames, numbers = dataset.column("frame_index"), dataset.column("episode_index")
    for episode in dataset.episodes:
        rows = slice(episode.start, episode.stop)
        if not np.array_equal(frames[rows], np.arange(len(episode))):
            yield Severity.FAIL, name_of(episode), "frame_index does not count the frames"
        if not (numbers[rows] == episode.index).all():
            yield Severity.FAIL, name_of(episode), "rows carry another episode_index"
        if np.abs(seconds[rows] - np.arange(len(episode)) / dataset.fps).max() > 1e-4 * max(1.0, len(episode) / 1000):
            yield Severity.FAIL, name_of(episode), "timestamp is not frame_index / fps"
        steps = np.diff(stamps[rows])
        if (steps <= 0).any():
            yield Severity.FAIL, name_of(episode), f"{int((steps <= 0).sum())} true stamps do not increase"
        elif (np.abs(steps - 1e9 / dataset.fps) > 1).any():
            yield Severity.FAIL, name_of(episode), "true stamps are not on the grid"
