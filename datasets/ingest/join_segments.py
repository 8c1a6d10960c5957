"""An episode's staged files: its segments joined into the files of a LeRobot data set."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np
from jaxtyping import Float32

from navtool.datasets.ingest.segment import Segment, SegmentResult, points_part, video_part
from navtool.datasets.store.data_file import Column, write_data
from navtool.datasets.store.schema import CLOUD_SIZE, POINTS_KEY, Contents, features_of, image_key
from navtool.datasets.store.staged_episode import EpisodeFolder, Numbering
from navtool.datasets.store.stats import CloudStats, ImageStats, Stats, column_stats
from navtool.datasets.store.video import join_videos
from navtool.pipeline.arrays import Array


def join_segments(
    contents: Contents,
    columns: Mapping[str, Column],
    segments: Sequence[Segment],
    results: Sequence[SegmentResult],
    *,
    fps: int,
    folder: Path,
    numbering: Numbering,
    on_reached: Callable[[int], None],
) -> EpisodeFolder:
    """Write the episode's data file and video out of its segments, and take the segments' own files away.

    Args:
        columns: Of all rows, clouds apart.
        folder: Where the segments lie.
        on_reached: Called with the number of segments before each; ends the work where it raises.
    """
    stats = _stats(contents, columns, results)
    joined = EpisodeFolder(folder, numbering, len(columns["frame_index"]), stats)
    points = [points_part(folder, segment.number) for segment in segments] if contents.lidar else []
    write_data(joined.data, features_of(contents), columns, _pieces(points, on_reached))
    for stream in contents.camera_streams:
        videos = [video_part(folder, stream, segment.number) for segment in segments]
        join_videos(videos, joined.video(image_key(stream)), fps)
        for part in videos:
            part.unlink()
    for part in points:
        part.unlink()
    return joined


def _pieces(points: Sequence[Path], on_reached: Callable[[int], None]) -> Iterator[Float32[Array, "ticks 10000 3"]]:
    for number, path in enumerate(points):
        on_reached(number)
        yield np.memmap(path, np.float32, "r").reshape(-1, CLOUD_SIZE, 3)


def _stats(contents: Contents, columns: Mapping[str, Column], results: Sequence[SegmentResult]) -> dict[str, Stats]:
    """Statistics of every column of numbers, of images and of clouds."""
    images, clouds = {image_key(stream): ImageStats() for stream in contents.camera_streams}, CloudStats()
    for result in results:
        clouds.merge(result.clouds)
        for stream, found in result.images.items():
            images[image_key(stream)].merge(found)
    stats = {}
    for key, feature in features_of(contents).items():
        if key in images:
            stats[key] = images[key].result()
        elif key == POINTS_KEY:
            stats[key] = clouds.result()
        elif feature.dtype != "string":
            stats[key] = column_stats(columns[key])
    return stats
