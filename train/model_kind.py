"""A kind of model: one row of the table in `navtool.train.models`."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from torch import Tensor, nn

from navtool.train.contract import Contract, Law, Timed, forward
from navtool.train.model_config import ModelConfig
from navtool.train.source import Source
from navtool.train.task import Task


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelKind[ConfigT: ModelConfig, NetworkT: nn.Module]:
    """All that runs, checkpoints, evaluation, export and verification need to know of a kind of model."""

    task: Task[Any, Any, Any, Any]
    """What it learns, from which data. (Its types agree with one another, and are nobody else's business.)"""
    config: type[ConfigT]
    """Its settings, ``model.*``. No two kinds share a class: a configuration's class says which kind it is of."""
    build: Callable[[ConfigT], NetworkT]
    """The network with weights drawn from torch's generator; reads no file."""
    inputs: Callable[[Any], tuple[Tensor, ...]]
    """What the network's forward takes of the task's batch, in the order of the contract."""
    begin: Callable[[NetworkT], None] | None = None
    """What is done to a network once, where its run begins, such as loading pretrained weights."""
    check_source: Callable[[Any, int, ConfigT], None] | None = None
    """Raises a TrainError where an episode of the source does not suit the network, such as images of another size."""
    stand_in: Callable[[ConfigT], Source]
    """Data made of numbers, for the golden inputs of an export where the run's own data are out of reach."""
    contract: Callable[[ConfigT], Contract]
    """What the artefact takes and gives."""
    onboard: Callable[[NetworkT, ConfigT], nn.Module]
    """The network as it goes into an artefact: scriptable, and refusing what breaks the contract."""
    laws: Mapping[str, Law] = field(default_factory=dict)
    """What verification checks besides the contract, by name."""
    timed: Mapping[str, Timed] = field(default_factory=lambda: {"one sample": forward})
    """What verification times, by what it is the time of; the first is timed most often."""


type AnyKind = ModelKind[Any, Any]
"""A row of the table, where kinds of all types stand side by side."""
