"""How well a topic's name fits a stream, where only types and names are known."""

import re
from dataclasses import dataclass, field

_TRUTH = "/ground_truth/"
"""What a simulator knows and no sensor has measured."""


@dataclass(frozen=True, slots=True)
class TopicHints:
    """Regular expressions on a topic's name in lower case, with what each adds to its score."""

    weights: tuple[tuple[str, int], ...] = ()
    needs: str = ""
    """What a name must have to be proposed; empty for nothing."""
    never: str = ""
    """What rules a name out; empty for nothing."""
    derived: str = ""
    """What is not a sensor's own but made from its messages: no further sensor of a robot; empty for nothing."""
    _patterns: tuple[tuple[re.Pattern[str], int], ...] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "_patterns", tuple((re.compile(text), weight) for text, weight in self.weights))

    def score(self, topic: str) -> int | None:
        """How well a topic's name fits; None where it rules the topic out.

        Zero means that the name says nothing; a negative score that it hints at something else.
        """
        text = topic.lower()
        if text.startswith(_TRUTH):
            return None
        if self.never and re.search(self.never, text):
            return None
        if self.needs and not re.search(self.needs, text):
            return None
        return sum(weight for pattern, weight in self._patterns if pattern.search(text))

    def is_derived(self, topic: str) -> bool:
        """Whether a topic's name says that what it carries was made from a sensor's messages."""
        return bool(self.derived and re.search(self.derived, topic.lower()))


NO_HINTS = TopicHints()
"""Every name fits alike."""
