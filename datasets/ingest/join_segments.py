"""An episode's staged files: its segments joined into the files of a LeRobot data set."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from navtool.datasets.ingest.segment import Segment, SegmentResult, video_part
from navtool.datasets.store.data_file import Column, write_data
from navtool.datasets.store.schema import Contents, features_of, image_key
from navtool.datasets.store.staged_episode import EpisodeFolder, Numbering
from navtool.datasets.store.stats import ImageStats, Stats, column_stats
from navtool.datasets.store.video import join_videos


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
    """Write the episode's data file and videos out of its segments, and take the segments' own files away.

    Args:
        columns: Of all rows.
        folder: Where the segments lie.
        on_reached: Called before each video, with a share of the segments; ends the work where it raises.
    """
    stats = _stats(contents, columns, results)
    joined = EpisodeFolder(folder, numbering, len(columns["frame_index"]), stats)
    write_data(joined.data, features_of(contents), columns)
    for number, stream in enumerate(contents.camera_streams):
        on_reached(len(segments) * number // len(contents.camera_streams))
        videos = [video_part(folder, stream, segment.number) for segment in segments]
        join_videos(videos, joined.video(image_key(stream)), fps)
        for part in videos:
            part.unlink()
    return joined


def _stats(contents: Contents, columns: Mapping[str, Column], results: Sequence[SegmentResult]) -> dict[str, Stats]:
    """Statistics of every column of numbers and of images."""
    images = {image_key(stream): ImageStats() for stream in contents.camera_streams}
    for result in results:
        for stream, found in result.images.items():
            images[image_key(stream)].merge(found)
    stats = {}
    for key, feature in features_of(contents).items():
        if key in images:
            stats[key] = images[key].result()
        elif feature.dtype != "string":
            stats[key] = column_stats(columns[key])
    return stats
