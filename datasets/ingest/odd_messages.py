"""What was odd about the messages of a recording and read all the same: counted, and told once a kind."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from navtool.base.note import Note
from navtool.datasets.recording import Recording
from navtool.datasets.streams.first_pass import FirstPass


@dataclass(slots=True)
class OddMessages:
    """Notes on single messages by stream and code, and bytes left behind messages by topic."""

    told: dict[tuple[str, str], str] = field(default_factory=dict)
    """The first note of a code on a stream's messages."""
    counts: Counter[tuple[str, str]] = field(default_factory=Counter)
    left: dict[str, Counter[int]] = field(default_factory=dict)
    """Numbers of messages by the bytes behind their last field, by topic."""

    def add(self, stream: str, notes: Iterable[Note]) -> None:
        """Count the notes on a message."""
        for code, text in {note.code: note.text for note in notes}.items():
            self.told.setdefault((stream, code), text)
            self.counts[stream, code] += 1

    def add_left(self, left: Mapping[str, Mapping[int, int]]) -> None:
        """Count bytes behind messages."""
        for topic, sizes in left.items():
            self.left.setdefault(topic, Counter()).update(sizes)

    def notes(self) -> list[Note]:
        """What a user should know, by stream."""
        notes = [
            Note(code, f"{stream}: {text}{_of(self.counts[stream, code])}")
            for (stream, code), text in sorted(self.told.items())
        ]
        for topic, sizes in sorted(self.left.items()):
            behind = " or ".join(str(size) for size in sorted(sizes))
            what = f"{topic}: {behind} bytes behind the last field of {sizes.total()} messages are not read"
            notes.append(Note("message.bytes-left", what))
        return notes


def odd_of_first_pass(found: FirstPass, recording: Recording) -> OddMessages:
    """What the first pass saw: all of the small streams, of images and clouds the first."""
    odd = OddMessages()
    for name, stream in found.streams.items():
        odd.add(name, stream.notes)
    odd.add_left(recording.bytes_left)
    return odd


def joined_odd(first: OddMessages, parts: Sequence[OddMessages]) -> OddMessages:
    """What both passes saw; the second one's counts, where it looked again."""
    joined = OddMessages()
    for part in parts:
        for key, text in part.told.items():
            joined.told.setdefault(key, text)
        joined.counts.update(part.counts)
        joined.add_left(part.left)
    for key, text in first.told.items():
        if key not in joined.told:
            joined.told[key], joined.counts[key] = text, first.counts[key]
    joined.left = {topic: Counter(sizes) for topic, sizes in first.left.items()} | joined.left
    return joined


def _of(count: int) -> str:
    return f" ({count} messages)" if count > 1 else ""
