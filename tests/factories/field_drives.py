"""Short drives whose camera records pictures of any kind, and what became of them in a data set."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import av
import cv2
import numpy as np
import pyarrow.parquet as pq
from drive_factory import START_NS, Entry, drive
from ingesting import ingested

from navtool.base.note import Note

STEP_NS = 100_000_000
DELAY_NS = 3_000_000
WIDTH, HEIGHT = 320, 240


def picture(number: int, width: int = WIDTH, height: int = HEIGHT) -> Any:
    """A smooth picture in colours whose bright bar stands at its number."""
    y, x = np.mgrid[0:height, 0:width]
    rgb = np.stack([x * 200 // width + 20, y * 200 // height + 20, np.full_like(x, 90)], axis=-1).astype(np.uint8)
    rgb[:, number * 8 % width : number * 8 % width + 16] = 240
    return rgb


def header(stamp_ns: int, frame: str = "camera_optical") -> dict[str, Any]:
    return {"header": {"stamp": {"sec": stamp_ns // 10**9, "nanosec": stamp_ns % 10**9}, "frame_id": frame}}


def raw(stamp_ns: int, samples: Any, encoding: str, **changes: Any) -> dict[str, Any]:
    """The fields of a raw image."""
    height, width = samples.shape[:2]
    data = np.ascontiguousarray(samples).view(np.uint8).reshape(-1)
    fields = {"height": height, "width": width, "encoding": encoding, "step": data.size // height, "data": data}
    return {**header(stamp_ns), **fields, **changes}


def camera_drive(
    make: Callable[[int, int], dict[str, Any]],
    count: int = 12,
    kind: str = "sensor_msgs/msg/Image",
    topic: str = "/camera/image_raw",
    streams: tuple[str, ...] = ("odometry", "tf"),
) -> list[Entry]:
    """A drive with a picture at 10 Hz that ``make`` makes of its number and stamp."""
    entries = drive(count / 10, streams=streams)
    stamps = [START_NS + k * STEP_NS for k in range(count)]
    entries += [(topic, kind, stamp + DELAY_NS, make(k, stamp)) for k, stamp in enumerate(stamps)]
    return sorted(entries, key=lambda entry: entry[2])


@dataclass
class Rows:
    """A data set of one episode."""

    table: Any
    pictures: list[Any]
    """RGB, (240, 320, 3), of every row."""
    notes: list[Note]
    dropped: dict[str, int]

    def column(self, key: str) -> Any:
        return np.array(self.table.column(key).to_pylist())


def rows_of(recording: Path, out: Path, **options: Any) -> Rows:
    """What ingest makes of a recording."""
    report = ingested([recording], out, **options)
    assert not report.quarantined, report.quarantined
    (data,) = out.glob("data/*/*.parquet")
    pictures = []
    for video in sorted(out.glob("videos/*/*/*.mp4"))[:1]:
        with av.open(str(video)) as container:
            pictures = [frame.to_ndarray(format="rgb24") for frame in container.decode(video=0)]
    (episode,) = report.episodes
    return Rows(pq.read_table(data), pictures, episode.notes, episode.dropped)


def likeness(one: Any, other: Any) -> float:
    """How alike two pictures are in shape, whatever their brightness: their correlation in grey."""
    grey = [cv2.cvtColor(x, cv2.COLOR_RGB2GRAY).astype(float).ravel() for x in (one, other)]
    return float(np.corrcoef(*grey)[0, 1])
