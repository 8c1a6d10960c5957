"""What a model learns, from which data, and how it is judged."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from matplotlib.figure import Figure
from torch import Tensor

from navtool.base.note import Note
from navtool.train.config import TrainConfig
from navtool.train.judgement import Judge
from navtool.train.samples import Batch, Samples
from navtool.train.source import Source


class Loss(NamedTuple):
    """The loss of a batch."""

    mean: Tensor
    """Mean over what was judged, a scalar with its gradient."""
    weight: int
    """How many values the mean is over: the epoch's logged loss weighs batches by it."""


@dataclass(frozen=True, slots=True)
class Remarks:
    """What a run says about its training samples."""

    figures: Mapping[str, float] = field(default_factory=dict)
    """Figures by name, for ``metrics.json``."""
    notes: tuple[Note, ...] = ()
    """What a person should know."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Picture[SamplesT, BatchT, OutputT]:
    """A picture of predictions."""

    choose: Callable[[SamplesT, int], list[int]]
    """At most so many samples that show something, by what is true of them; ascending."""
    draw: Callable[[Sequence[BatchT], OutputT, TrainConfig], Figure]
    """Samples, not batched, and the network's output for the batch of them."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Task[SourceT: Source, SamplesT: Samples[Any], BatchT: Batch, OutputT]:
    """What the loop, evaluation and export ask of the data and the loss; models that learn the same share one."""

    open: Callable[[Path], SourceT]
    """The data in a folder."""
    samples: Callable[[SourceT, Sequence[int], TrainConfig], SamplesT]
    """The samples of some episodes, planned but not read."""
    loss: Callable[[OutputT, BatchT], Loss]
    """What training makes smaller."""
    judge: Callable[[TrainConfig], Judge[BatchT, OutputT]]
    """A fresh judge of validation, evaluation and test."""
    hold: Callable[[Sequence[SamplesT], TrainConfig], None] | None = None
    """Reads what training wants in memory, once before it begins; None reads each epoch anew."""
    remarks: Callable[[SamplesT], Remarks] | None = None
    """What a run says about its training samples."""
    picture: Picture[SamplesT, BatchT, OutputT] | None = None
    """Drawn into TensorBoard, and on request."""
