"""Messages of a recording that reach no row, as far as the first pass knows."""

from collections.abc import Mapping

from navtool.datasets.ingest.grid import Grid
from navtool.datasets.ingest.large_stream import LargeStream
from navtool.datasets.store.schema import Contents
from navtool.datasets.streams.first_pass import FirstPass
from navtool.datasets.streams.table import is_large


def dropped_messages(
    found: FirstPass, grid: Grid, large: Mapping[str, LargeStream], contents: Contents
) -> dict[str, int]:
    """Counts of messages that reach no row, by reason; the native streams and clouds keep them all the same."""
    counts: dict[str, int] = {}
    first_ns, last_ns = int(grid.ticks_ns[0]), int(grid.ticks_ns[-1])
    for name, stream in large.items():
        if name in contents.large:
            video = found.streams[name].video
            counts[f"{name}: before the first key frame"] = 0 if video is None else video.before_first_key
            unserving = [stamp for n, stamp in stream.stamps_ns.items() if n not in stream.episode_ticks]
            inside = sum(first_ns <= stamp <= last_ns for stamp in unserving)
            counts[f"{name}: outside the grid"] = len(unserving) - inside
            counts[f"{name}: another message is nearer to the tick"] = inside
    for name, time in grid.times.items():
        counts[f"{name}: stamp repeated"] = time.repeated
        counts[f"{name}: no stamp"] = time.unstamped
        counts[f"{name}: of another source on its topic"] = found.streams[name].left_out
        if not is_large(name):
            counts[f"{name}: cannot be decoded"] = found.streams[name].undecodable
    counts |= {f"{name}: cannot be decoded": stream.undecodable for name, stream in found.unreadable.items()}
    return {reason: count for reason, count in counts.items() if count}
