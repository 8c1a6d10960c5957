"""Are the values, clouds, frames and streams plausible?"""

from typing import Any

import av
import numpy as np
from jaxtyping import Bool

from navtool.base.lineage import file_sha256
from navtool.datasets.check.findings import Findings, Severity, first_line, name_of, runs, short
from navtool.datasets.store.reader import NavDataset
from navtool.datasets.store.schema import (
    CLOUD_SIZE,
    COUNT_KEY,
    IMAGE_KEY,
    STATE_KEY,
    image_key,
)
from navtool.pipeline.arrays import Array

INVALID_SHARE = 0.05
"""A stream that is not valid in more than this share of an episode's rows is worth a warning."""
GAP_S = 2.0
"""So is one that is missing for this long."""
FROZEN_S = 5.0
"""And one that does not change in the last digit for this long."""


def check_values(dataset: NavDataset) -> Findings:
    """No NaN, no infinity, reliabilities in [0, 1], outcomes 0 or 1."""
    for key, feature in dataset.features.items():
        if feature.dtype != "float32":
            continue
        bad = ~np.isfinite(dataset.column(key))
        if bad.any():
            yield Severity.FAIL, key, f"{int(bad.sum())} values are NaN or infinite"
    for key in dataset.features:
        if key.startswith("reliability.") or key == "label.confidence":
            values = dataset.column(key)
            outside = int(((values < 0) | (values > 1)).sum())
            if outside:
                yield Severity.FAIL, key, f"{outside} values are outside 0 to 1"
    outcomes = dataset.column("label.outcome")
    if not np.isin(outcomes, (0, 1)).all():
        yield Severity.FAIL, "label.outcome", "has values other than 0 and 1"


def check_clouds(dataset: NavDataset) -> Findings:
    """Every row's cloud has as many points as the row says, and it is not the same again and again."""
    if not dataset.description.contents.lidar:
        return
    counts = dataset.column(COUNT_KEY)
    valid = dataset.column("valid.lidar")
    if ((counts < 0) | (counts > CLOUD_SIZE)).any():
        yield Severity.FAIL, COUNT_KEY, f"counts outside 0 to {CLOUD_SIZE}"
        return
    for episode in dataset.episodes:
        miscounted = 0
        same = np.zeros(len(episode), dtype=np.bool_)
        previous: Array | None = None
        for row in range(episode.start, episode.stop):
            points = dataset.distinct_points(row)
            miscounted += int(len(points) != counts[row])
            same[row - episode.start] = valid[row] and previous is not None and np.array_equal(points, previous)
            previous = points
        if miscounted:
            yield Severity.FAIL, name_of(episode), f"{miscounted} clouds have another number of points than {COUNT_KEY}"
        empty = int((valid & (counts == 0))[episode.start : episode.stop].sum())
        if empty:
            yield Severity.WARN, name_of(episode), f"{empty} clouds have no point in the front half plane"
        yield from _frozen(dataset, name_of(episode), "the cloud", same)


def check_video(dataset: NavDataset) -> Findings:
    """Every image decodes, there is one a row, and the picture changes."""
    for stream in dataset.description.contents.camera_streams:
        yield from _video(dataset, stream)


def _video(dataset: NavDataset, stream: str) -> Findings:
    key = image_key(stream)
    for episode in dataset.episodes:
        path = dataset.layout.video(episode.index, key)
        made = _video_sha256(dataset.provenance_of(episode.index), key)
        if path.is_file() and made is not None and file_sha256(path) != made:
            yield Severity.FAIL, short(dataset, path), "its bytes are not those that ingest wrote"
        try:
            with av.open(str(path)) as container:
                frames, same, previous = 0, [], None
                for frame in container.decode(video=0):
                    thumbnail = frame.reformat(width=32, height=24, format="gray").to_ndarray()
                    same.append(previous is not None and np.array_equal(thumbnail, previous))
                    previous, frames = thumbnail, frames + 1
        except (OSError, av.FFmpegError) as error:
            yield Severity.FAIL, short(dataset, path), f"cannot be decoded: {first_line(error)}"
            continue
        if frames != len(episode):
            yield Severity.FAIL, short(dataset, path), f"{frames} frames instead of {len(episode)}"
            continue
        valid = dataset.column(f"valid.{stream}")[episode.start : episode.stop]
        if frames > 1 and valid.any() and all(same[1:]):
            yield Severity.WARN, short(dataset, path), "every frame looks the same"
        else:
            yield from _frozen(dataset, short(dataset, path), "the picture", np.array(same) & valid)


def _video_sha256(provenance: dict[str, Any], key: str) -> str | None:
    """The hash with which ingest wrote a video; None where it wrote none."""
    made: str | None = provenance.get("further_videos_sha256", {}).get(key)
    return provenance.get("video_sha256") if key == IMAGE_KEY else made


def check_streams(dataset: NavDataset) -> Findings:
    """Streams are valid in most rows, without long pauses, and the measured speed is alive."""
    for stream in dataset.description.contents.streams():
        valid = dataset.column(f"valid.{stream}")
        for episode in dataset.episodes:
            rows = valid[episode.start : episode.stop]
            share = 1.0 - float(rows.mean())
            if share > INVALID_SHARE:
                yield (
                    Severity.WARN,
                    name_of(episode),
                    f"{stream} is {'never valid' if share == 1 else f'not valid in {share:.0%} of the rows'}",
                )
            if stream == "action" and not rows.any():
                continue
            for first, end in runs(~rows):
                if end - first >= GAP_S * dataset.fps and end - first < len(episode):
                    at, lasts = first / dataset.fps, (end - first) / dataset.fps
                    yield Severity.WARN, name_of(episode), f"{stream} is missing for {lasts:.1f} s at {at:.1f} s"
    speeds = dataset.column(STATE_KEY)
    for episode in dataset.episodes:
        rows = speeds[episode.start : episode.stop]
        moving = (np.abs(rows) > 1e-6).any(axis=1)
        same = np.concatenate([[False], (np.diff(rows, axis=0) == 0).all(axis=1)]) & moving
        yield from _frozen(dataset, name_of(episode), "the measured speed", same)


def _frozen(dataset: NavDataset, where: str, what: str, same: Bool[Array, " rows"]) -> Findings:
    """A finding where so many rows in a row equal the one before."""
    longest = max((end - first for first, end in runs(same)), default=0)
    if longest >= FROZEN_S * dataset.fps:
        yield Severity.WARN, where, f"{what} is frozen for {longest / dataset.fps:.1f} s"
