"""Third step from a recording to an episode: what was read of it is joined."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from navtool.base.files import write_bytes, write_json
from navtool.base.meter import Meter
from navtool.base.note import Note
from navtool.base.plain import plain
from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.ingest.join_segments import join_segments
from navtool.datasets.ingest.joined_columns import joined_columns
from navtool.datasets.ingest.odd_messages import joined_odd
from navtool.datasets.ingest.output_errors import output_errors
from navtool.datasets.ingest.plan import EpisodePlan
from navtool.datasets.ingest.segment import Segment, SegmentResult
from navtool.datasets.ingest.sync_picture import sync_picture
from navtool.datasets.store.staged_episode import EpisodeFolder, Numbering


@dataclass(frozen=True, slots=True)
class Joined:
    """A recording's episode, staged whole, and what is to be said of it."""

    folder: EpisodeFolder
    dropped: dict[str, int]
    notes: list[Note]


def join_step(
    plan: EpisodePlan,
    segments: Sequence[Segment],
    results: Sequence[SegmentResult],
    numbering: Numbering,
    config: IngestConfig,
    staged: Path,
    meter: Meter,
) -> Joined:
    """Join what was read of a recording into the staged files of an episode, with its likely number."""
    columns = joined_columns(plan, segments, results, numbering, config.fps)
    with output_errors(staged):
        folder = join_segments(
            plan.contents,
            columns,
            segments,
            results,
            fps=config.fps,
            folder=staged,
            numbering=numbering,
            on_reached=meter.part(0, len(segments)),
        )
    dropped = _dropped(plan, results)
    odd = joined_odd(plan.odd, [part for result in results for part in result.odd])
    notes = [*plan.notes, *odd.notes(), *_deskew_notes(results), *plan.time_notes]
    write_json(folder.beside / "calibration.json", plan.calibration.to_json())
    write_json(folder.beside / "sync.json", plan.sync_report | {"dropped": dropped, "notes": plain(notes)})
    write_bytes(folder.beside / "sync.svg", sync_picture(plan.sync_report, columns, config.fps).encode())
    return Joined(folder, dropped, notes)


def _dropped(plan: EpisodePlan, results: Sequence[SegmentResult]) -> dict[str, int]:
    dropped = dict(plan.dropped)
    for result in results:
        for name, count in result.undecodable.items():
            key = f"{name}: cannot be decoded"
            dropped[key] = dropped.get(key, 0) + count
    for result in results:
        for name, count in result.points_nonfinite.items():
            if count:
                key = f"{name} points: not finite"
                dropped[key] = dropped.get(key, 0) + count
    return dropped


def _deskew_notes(results: Sequence[SegmentResult]) -> list[Note]:
    left = sum(result.not_deskewed for result in results)
    what = f"lidar: {left} clouds without point times or odometry around them; points stay as measured"
    return [Note("lidar.not-deskewed", what)] if left else []
