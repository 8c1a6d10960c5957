"""Second step from a recording to an episode: one of its segments is read."""

from pathlib import Path

from navtool.base.meter import Meter
from navtool.datasets.ingest.config import IngestConfig, Merge
from navtool.datasets.ingest.output_errors import output_errors
from navtool.datasets.ingest.segment import Segment, SegmentResult
from navtool.datasets.ingest.write_segment import write_segment
from navtool.datasets.recording import open_recording


def segment_step(path: Path, segment: Segment, config: IngestConfig, staged: Path, meter: Meter) -> SegmentResult:
    """Read one segment of a recording and write its part of the episode."""
    merged = config.merge is Merge.folder
    with output_errors(staged), open_recording(path, merged=merged, verify=not segment.sound) as recording:
        return write_segment(recording, segment, config, staged, meter.part(segment.start_ns, segment.end_ns))
