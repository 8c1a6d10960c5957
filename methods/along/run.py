"""The one loop that walks a recording or an episode with a method, from its readings to the files."""

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import chain, islice
from pathlib import Path

from navtool.base.background import Background
from navtool.base.errors import DatasetsError
from navtool.base.lineage import code_version, file_sha256
from navtool.base.meter import Meter
from navtool.base.output_folder import OutputFolder
from navtool.base.progress import Progress
from navtool.methods.along.annotations import read_annotations
from navtool.methods.along.method import Method, Walked
from navtool.methods.along.observation import Observation, Skip
from navtool.methods.along.place_truth import TRUTH_CURE, PlaceTruth
from navtool.methods.along.report import Report
from navtool.methods.along.source import Source
from navtool.methods.along.streams import Streams
from navtool.methods.along.writers import Outcome, Writers

_SHARES = 1000
"""In how many parts the progress along one input is counted."""


def run_along[T, R, P: Report](
    sources: Sequence[Source], method: Method[T, R, P], out: Path, progress: Progress, truth: Path | None = None
) -> P:
    """Walk along inputs with a method, unless the output lies in the folder already.

    The folder is there whole, or not at all. The same inputs and settings give the same bytes. Memory does not grow
    with the inputs, unless the method's own does. What the method's writers write is written in a thread beside.

    Args:
        sources: Recordings or episodes that are open; one, or several where the method takes several.
        method: A new one.
        out: A folder that is not there, is empty, or holds the output of the same inputs and settings.
        progress: Learns how far the walk is.
        truth: Annotations in the frame of the odometry, of all inputs; None where each brings its own, as simulated
            recordings do, or none.

    Raises:
        DatasetsError: An input cannot be read or gives nothing, with the reason, nothing says what stands there where
            the method needs it, or the folder holds something else.
        OutputError: The folder cannot be written.
    """
    OutputFolder(out, method.kind).refuse_other()
    folder = OutputFolder(out, method.kind, _identity(sources, method, truth))
    if (before := folder.finished(method.report_type)) is not None:
        return replace(before, done_before=True)
    begun = time.monotonic()
    walked = Walked(out.as_posix())
    with folder.staged() as staging:
        progress.begin(len(sources), _SHARES * len(sources))
        for number, source in enumerate(sources, 1):
            with Meter(_SHARES, progress.advance) as meter:
                _Walk(source, method, truth, walked).along(staging, meter)
            progress.done(number, walked.names[-1])
        report = method.report(walked)
        method.finish(staging, report)
        about = [source.about() for source in sources]
        folder.write_record(staging, about if method.several else about[0], report)
    return replace(report, seconds=time.monotonic() - begun)


def _identity[T, R, P: Report](
    sources: Sequence[Source], method: Method[T, R, P], truth: Path | None
) -> dict[str, object]:
    """What has to be equal for the same output."""
    each = [source.identity(method.settings) for source in sources]
    known = None if truth is None else file_sha256(truth)
    if not method.several:
        return {**each[0], "truth": known}
    settings = [one["settings"] for one in each]
    return {
        "inputs": [one["input"] for one in each],
        "truth": known,
        "settings": settings[0] if settings.count(settings[0]) == len(settings) else settings,
        "code_version": code_version(),
    }


@dataclass(slots=True)
class _Walk[T, R, P: Report]:
    """The walk along one input."""

    source: Source
    method: Method[T, R, P]
    truth: Path | None
    walked: Walked

    def along(self, folder: Path, meter: Meter) -> None:
        """Take every step, and have written what they give."""
        method, walked = self.method, self.walked
        known = self._known()
        reads = dict.fromkeys(chain(method.ticks.reads, *(beside.reads for beside in method.beside)))
        streams = self.source.streams(tuple(reads), method.odometry_gap_s)
        known = None if known is None else known.in_odometry(streams)
        walked.ticks += method.ticks.count(streams)
        walked.duration_s += method.ticks.duration_s(streams)
        walked.names.append(streams.name)
        observed = self._observed(streams, meter.part(0, method.ticks.count(streams)))
        first = list(islice(observed, method.preview))
        if not first:
            raise method.nothing(streams, walked)
        method.begin(streams, known, [observation.reading for observation in first])
        # the thread beside is left before the files that it writes to are closed
        with Writers(method.writers(folder, streams)) as writers, Background() as beside:
            for outcome in self._outcomes(chain(first, observed)):
                beside.call(writers.add, outcome)
            method.end(streams, walked)
            beside.call(writers.finish)
        walked.written |= writers.written()
        walked.notes += [note.about(streams.name) if method.several else note for note in streams.notes]

    def _known(self) -> PlaceTruth | None:
        """What is known to stand there."""
        if self.truth is not None:
            return PlaceTruth(read_annotations(self.truth), None)
        known = self.source.truth(self.method.odometry_gap_s)
        if known is None and self.method.needs_truth:
            raise DatasetsError("nothing says what stands there", where=self.source.path, cure=TRUTH_CURE)
        return known

    def _observed(self, streams: Streams, on_reached: Callable[[int], None]) -> Iterator[Observation[T]]:
        """The ticks that can be read; the others are counted."""
        for number, (stamp_ns, read) in enumerate(self.method.ticks.readings(streams)):
            on_reached(number)
            reading = read()
            if not isinstance(reading, Skip):
                yield Observation(stamp_ns, reading, streams)
                continue
            if reading.note is not None and reading.reason not in self.walked.unread:
                streams.notes.append(reading.note)
            self.walked.unread[reading.reason] += 1

    def _outcomes(self, observed: Iterator[Observation[T]]) -> Iterator[Outcome[R]]:
        """The results of the steps; what the method skips is counted."""
        walked, first_ns = self.walked, None
        for observation in observed:
            result = self.method.step(observation)
            if isinstance(result, Skip):
                if result.note is not None and result.reason not in walked.skipped:
                    walked.skip_notes.append(result.note)
                walked.skipped[result.reason] += 1
            elif result is not None:
                first_ns = observation.stamp_ns if first_ns is None else first_ns
                seconds = (observation.stamp_ns - first_ns) * 1e-9
                yield Outcome(walked.results, observation.stamp_ns, seconds, result)
                walked.results += 1
