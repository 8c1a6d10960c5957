"""How good predictions are: what a task's judge says once it has seen all batches."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol

from navtool.base.note import Note


class Table(NamedTuple):
    """Figures for a person."""

    title: str
    """What was judged, such as ``Success prediction``."""
    columns: Sequence[str]
    """What the figures of a row are of."""
    rows: Sequence[tuple[str | float | None, ...]]
    """One row a metric: its name, and its figure for each column; None where it is undefined."""


@dataclass(frozen=True, slots=True)
class Judgement:
    """Figures over all samples, however they were batched."""

    loss: float
    """What the best checkpoint has least of."""
    metrics: object
    """The task's own figures: a dataclass or mapping that turns into JSON."""
    logged: Mapping[str, float | None]
    """Those that are logged after each epoch, as ``val/<name>``; None where the samples do not define one."""
    table: Table
    """The figures for a person."""
    notes: tuple[Note, ...] = ()
    """What the figures alone would hide, such as predictions that are all the same."""


class Judge[BatchT, OutputT](Protocol):
    """Collects what a network says; keeps of each batch only what its figures need."""

    def add(self, batch: BatchT, output: OutputT) -> None:
        """Take a batch, and what the network made of it."""

    def result(self) -> Judgement:
        """The figures of all that was taken; at least one batch."""
