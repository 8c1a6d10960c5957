"""Second pass over a recording, one segment of it: frames and clouds read, judged, made small and written."""

from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path

from navtool.base.background import Background
from navtool.datasets.ingest.camera_lane import CameraLane
from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.ingest.lidar_lane import LidarLane
from navtool.datasets.ingest.segment import Segment, SegmentResult, clouds_part, points_part, video_part
from navtool.datasets.recording import Recording
from navtool.datasets.recording.changed import changed_meanwhile
from navtool.datasets.store.sidecar import CloudFile
from navtool.datasets.store.video import VideoWriter


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
    Frames are worked on in a thread of their own, beside the clouds.

    Args:
        folder: The episode's staged folder.
        on_reached: Called with the record time of each message read.

    Raises:
        DatasetsError: The recording does not hold the messages any more that the first pass saw.
    """
    folder.mkdir(parents=True, exist_ok=True)
    with ExitStack() as stack:
        # The thread beside is left before any file that it writes to is closed, whatever happens here.
        files = stack.enter_context(ExitStack())
        beside = stack.enter_context(Background())
        camera = _camera_lane(segment, config, folder, files) if segment.image else None
        lidar = (
            _lidar_lane(segment, config, folder, files, beside) if segment.lidar or "lidar" in segment.parts else None
        )
        if segment.end_ns >= segment.start_ns:
            topics = {part.topic: name for name, part in segment.parts.items()}
            position = {name: part.first for name, part in segment.parts.items()}
            expected = {name: iter(part.record_ns.tolist()) for name, part in segment.parts.items()}
            for raw in recording.messages(tuple(topics), segment.start_ns, segment.end_ns):
                name = topics[raw.topic]
                if next(expected[name], None) != raw.record_ns:
                    raise changed_meanwhile(recording.path)
                if name == "image" and camera is not None:
                    beside.call(camera.take, recording, raw, position[name])
                elif name == "lidar" and lidar is not None:
                    lidar.take(recording, raw, position[name])
                position[name] += 1
                if on_reached is not None:
                    on_reached(raw.record_ns)
            if any(next(left, None) is not None for left in expected.values()):
                raise changed_meanwhile(recording.path)
        if camera is not None:
            beside.call(camera.finish)
        if lidar is not None:
            lidar.finish()
    return _result(segment, camera, lidar)


def _camera_lane(segment: Segment, config: IngestConfig, folder: Path, files: ExitStack) -> CameraLane:
    video = files.enter_context(VideoWriter(video_part(folder, segment.number), config.fps))
    return CameraLane(segment.parts.get("image"), segment.ticks, video, config.image_reliability)


def _lidar_lane(
    segment: Segment, config: IngestConfig, folder: Path, files: ExitStack, beside: Background
) -> LidarLane:
    points = files.enter_context(points_part(folder, segment.number).open("wb")) if segment.lidar else None
    there = "lidar" in segment.parts
    clouds = files.enter_context(CloudFile(clouds_part(folder, segment.number))) if there else None
    return LidarLane(segment, points, clouds, config, beside)


def _result(segment: Segment, camera: CameraLane | None, lidar: LidarLane | None) -> SegmentResult:
    result = SegmentResult()
    for name, lane in (("image", camera), ("lidar", lidar)):
        if lane is not None:
            if getattr(segment, name):
                result.columns |= lane.columns
                if lane.lost:
                    result.lost[name] = lane.lost
            if lane.undecodable:
                result.undecodable[name] = lane.undecodable
    if camera is not None:
        result.images = camera.stats
    if lidar is not None:
        result.clouds = lidar.stats
        result.points_nonfinite, result.not_deskewed = lidar.points_nonfinite, lidar.not_deskewed
    return result
