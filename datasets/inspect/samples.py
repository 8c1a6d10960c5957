"""What the page shows of a recording: when its topics speak, a few frames, a cloud, the path driven."""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import cv2
import numpy as np
from jaxtyping import Float64, Int64, UInt8

from navtool.base.errors import DatasetsError
from navtool.datasets.decode.levels import levels_of
from navtool.datasets.decode.messages import ImageFrame, OdometrySample, PointCloud, PoseSample, VideoPacket
from navtool.datasets.decode.picture_view import PictureView
from navtool.datasets.decode.video_decoder import VideoDecoder
from navtool.datasets.inspect.inspection import Inspection
from navtool.datasets.recording import RawMessage, Recording, open_recording
from navtool.datasets.streams.table import is_large
from navtool.pipeline.arrays import Array

_MOST_BINS = 240
_BINS_PER_S = 2.0
MOST_POSES = 4000
_VIEW_PX = 420
_REACH_M = 30.0


@dataclass(frozen=True, slots=True)
class Frame:
    """A camera's image as a small JPEG."""

    stream: str
    at_s: float
    jpeg: bytes


@dataclass(frozen=True, slots=True)
class Cloud:
    """A cloud from above and from the side, as PNG."""

    at_s: float
    points: int
    above: bytes
    side: bytes


@dataclass(slots=True)
class Samples:
    """Everything that the page draws."""

    density: dict[str, Int64[Array, " bins"]]
    """Messages of each topic in each portion of time, by time of record; half a second each, or longer."""
    frames: list[Frame] = field(default_factory=list)
    clouds: dict[str, Cloud] = field(default_factory=dict)
    """One of each LiDAR, by stream."""
    path: Float64[Array, "n 3"] = field(default_factory=lambda: np.zeros((0, 3)))
    """Seconds, x and y of the odometry."""
    faults: list[str] = field(default_factory=list)
    """Samples that could not be decoded."""


def take_samples(path: Path, inspection: Inspection, on_read: Callable[[int], None] | None = None) -> Samples:
    """Read a recording once more and decode what the page shows of it; memory does not grow with its length.

    Args:
        on_read: Called with the size of each message in bytes.
    """
    streams = inspection.topic_map.streams
    span_ns = max(inspection.end_ns - inspection.start_ns, 1)
    bins = int(np.clip(span_ns * 1e-9 * _BINS_PER_S, 8, _MOST_BINS))
    samples = Samples({topic.name: np.zeros(bins, dtype=np.int64) for topic in inspection.topics if topic.count})
    kept: dict[str, dict[int, RawMessage]] = {name: {} for name in streams if is_large(name)}
    of_topic = {streams[name]: name for name in kept}
    odometry = streams.get("odometry")
    counts = {topic.name: topic.count for topic in inspection.topics}
    every = max(1, counts.get(odometry or "", 0) // MOST_POSES)
    poses: list[tuple[float, float, float]] = []
    seen = 0
    with open_recording(path) as recording:
        for raw in recording.messages(samples.density):
            since_ns = raw.record_ns - inspection.start_ns
            samples.density[raw.topic][min(since_ns * bins // span_ns, bins - 1)] += 1
            if raw.topic in of_topic:
                # The first of the recording and of its second half, and the last.
                shown = kept[of_topic[raw.topic]]
                shown.setdefault(min(2 * since_ns // span_ns, 1), raw)
                shown[2] = raw
            elif raw.topic == odometry:
                if seen % every == 0:
                    poses += _pose(recording, raw, since_ns * 1e-9, samples)
                seen += 1
            if on_read is not None:
                on_read(len(raw.data))
        samples.path = np.array(poses, dtype=np.float64).reshape(-1, 3)
        _decode_kept(recording, kept, inspection.start_ns, samples)
    return samples


def _pose(recording: Recording, raw: RawMessage, at_s: float, samples: Samples) -> list[tuple[float, float, float]]:
    try:
        sample = recording.decode(raw)
    except DatasetsError as error:
        samples.faults.append(error.what)
        return []
    if isinstance(sample, OdometrySample | PoseSample) and np.isfinite(sample.position).all():
        return [(at_s, float(sample.position[0]), float(sample.position[1]))]
    return []


def _decode_kept(recording: Recording, kept: dict[str, dict[int, RawMessage]], start_ns: int, samples: Samples) -> None:
    for stream, shown in kept.items():
        pictures: list[tuple[float, ImageFrame]] = []
        for raw in {id(raw): raw for _, raw in sorted(shown.items())}.values():
            at_s = (raw.record_ns - start_ns) * 1e-9
            try:
                sample = recording.decode(raw)
            except DatasetsError as error:
                samples.faults.append(f"{raw.topic}: {error.what}")
                continue
            if isinstance(sample, VideoPacket):
                decoder = VideoDecoder()
                pictures += [(at_s, shown.frame) for shown in (*decoder.feed(sample, 0), *decoder.flush())]
            elif isinstance(sample, ImageFrame):
                pictures.append((at_s, sample))
            elif isinstance(sample, PointCloud) and stream not in samples.clouds and len(sample.xyz):
                samples.clouds[stream] = _cloud(sample, at_s)
        levels = levels_of([picture.deep.samples for _, picture in pictures if picture.deep is not None])
        shown_at = [(at_s, PictureView(levels).shown(picture)) for at_s, picture in pictures]
        samples.frames += [Frame(stream, at_s, _jpeg(picture.rgb)) for at_s, picture in shown_at]


def _jpeg(rgb: UInt8[Array, "h w 3"]) -> bytes:
    height, width = rgb.shape[:2]
    size = (340, max(1, round(340 * height / width)))
    small = cv2.resize(rgb, size, interpolation=cv2.INTER_AREA if width > 340 else cv2.INTER_LINEAR)
    return bytes(cv2.imencode(".jpg", cv2.cvtColor(small, cv2.COLOR_RGB2BGR), [cv2.IMWRITE_JPEG_QUALITY, 80])[1])


def _cloud(cloud: PointCloud, at_s: float) -> Cloud:
    """Coloured by intensity between its 2nd and 98th percentile, else by height."""
    values = cloud.intensity if cloud.intensity is not None else cloud.xyz[:, 2]
    low, high = np.quantile(values, (0.02, 0.98))
    level = np.clip((values - low) / max(float(high - low), 1e-9), 0, 1)
    colours = cv2.applyColorMap((level * 255).astype(np.uint8)[:, None], cv2.COLORMAP_VIRIDIS)[:, 0]
    x, y, z = cloud.xyz.T
    above = _drawn(-y, -x, colours, _VIEW_PX, _VIEW_PX)
    side = _drawn(x, -z, colours, _VIEW_PX, _VIEW_PX // 3)
    return Cloud(at_s, len(cloud.xyz), above, side)


def _drawn(across: Array, down: Array, colours: UInt8[Array, "n 3"], width: int, height: int) -> bytes:
    """Points on a dark ground, the sensor in the middle; to scale."""
    scale = width / (2 * _REACH_M)
    column, row = (across * scale + width / 2).astype(np.int64), (down * scale + height / 2).astype(np.int64)
    inside = (column >= 0) & (column < width) & (row >= 0) & (row < height)
    picture = np.full((height, width, 3), (26, 20, 16), np.uint8)
    picture[row[inside], column[inside]] = colours[inside]
    cv2.circle(picture, (width // 2, height // 2), 3, (255, 255, 255), -1)
    return bytes(cv2.imencode(".png", picture)[1])
