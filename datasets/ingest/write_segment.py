"""Second pass over a recording, one segment of it: frames and clouds read, judged, made small and written."""

from collections import Counter
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from pathlib import Path

from navtool.base.background import Background
from navtool.datasets.ingest.camera_lane import CameraLane
from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.ingest.lidar_lane import LidarLane
from navtool.datasets.ingest.odd_messages import OddMessages
from navtool.datasets.ingest.segment import Segment, SegmentResult, clouds_part, row_points_part, video_part
from navtool.datasets.recording import Recording
from navtool.datasets.recording.changed import changed_meanwhile
from navtool.datasets.store.row_points import PointsFile
from navtool.datasets.store.sidecar import CloudFile
from navtool.datasets.store.video import VideoWriter
from navtool.datasets.streams.table import row_of


def write_segment(
    recording: Recording,
    segment: Segment,
    config: IngestConfig,
    folder: Path,
    on_reached: Callable[[int], None] | None = None,
) -> SegmentResult:
    """Read a segment's images and clouds and write its parts of the episode's files.

    Reliabilities are computed from the raw frame and the raw cloud, before any resizing, thinning or encoding. A
    message that cannot be decoded leaves its ticks without it and is counted. Memory does not grow with the length.
    Images have a thread of their own, and so have the files of whole clouds, beside the one that reads and thins them.

    Args:
        folder: The episode's staged folder.
        on_reached: Called with the record time of each message read.

    Raises:
        DatasetsError: The recording does not hold the messages any more that the first pass saw.
    """
    folder.mkdir(parents=True, exist_ok=True)
    with ExitStack() as stack:
        # The threads beside are left before any file that they write to is closed, whatever happens here.
        files = stack.enter_context(ExitStack())
        images, whole = stack.enter_context(Background()), stack.enter_context(Background())
        lanes = _lanes(segment, config, folder, files, whole)
        if segment.end_ns >= segment.start_ns:
            topics: dict[str, list[str]] = {}
            for name, part in segment.parts.items():
                topics.setdefault(part.topic, []).append(name)
            position = {name: part.first for name, part in segment.parts.items()}
            expected = {name: iter(part.record_ns.tolist()) for name, part in segment.parts.items()}
            for raw in recording.messages(tuple(topics), segment.start_ns, segment.end_ns):
                for name in topics[raw.topic]:
                    if next(expected[name], None) != raw.record_ns:
                        raise changed_meanwhile(recording.path)
                    lane = lanes[name]
                    if isinstance(lane, CameraLane):
                        images.call(lane.take, recording, raw, position[name])
                    else:
                        lane.take(recording, raw, position[name])
                    position[name] += 1
                if on_reached is not None:
                    on_reached(raw.record_ns)
            if any(next(left, None) is not None for left in expected.values()):
                raise changed_meanwhile(recording.path)
        for lane in lanes.values():
            if isinstance(lane, CameraLane):
                images.call(lane.finish)
            else:
                lane.finish()
    return _result(segment, lanes, recording.bytes_left)


def _lanes(
    segment: Segment, config: IngestConfig, folder: Path, files: ExitStack, whole: Background
) -> dict[str, CameraLane | LidarLane]:
    """A lane for each stream that the rows have or that the recording has."""
    lanes: dict[str, CameraLane | LidarLane] = {}
    for stream in dict.fromkeys((*segment.in_rows, *segment.parts)):
        if row_of(stream).name == "camera":
            video = files.enter_context(VideoWriter(video_part(folder, stream, segment.number), config.fps))
            lanes[stream] = CameraLane(stream, segment, video, config.image_reliability)
        else:
            lanes[stream] = _lidar_lane(stream, segment, config, folder, files, whole)
    return lanes


def _lidar_lane(
    stream: str, segment: Segment, config: IngestConfig, folder: Path, files: ExitStack, beside: Background
) -> LidarLane:
    wanted, there = stream in segment.in_rows, stream in segment.parts
    points = files.enter_context(PointsFile(row_points_part(folder, segment.number))) if wanted else None
    clouds = files.enter_context(CloudFile(clouds_part(folder, stream, segment.number))) if there else None
    return LidarLane(stream, segment, points, clouds, config, beside)


def _result(
    segment: Segment, lanes: Mapping[str, CameraLane | LidarLane], bytes_left: dict[str, Counter[int]]
) -> SegmentResult:
    result = SegmentResult(odd=[OddMessages(left=bytes_left)])
    for name, lane in lanes.items():
        result.odd.append(lane.odd)
        if name in segment.in_rows:
            result.columns |= lane.columns
            if lane.lost:
                result.lost[name] = lane.lost
        if lane.undecodable:
            result.undecodable[name] = lane.undecodable
        if isinstance(lane, CameraLane):
            result.images[name] = lane.stats
        else:
            result.points_nonfinite[name] = lane.points_nonfinite
            if name in segment.in_rows:
                result.not_deskewed = lane.not_deskewed
    return result
