"""Golden inputs and the output that the network gave for them when it was exported."""

from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np
import safetensors.torch
from numpy.typing import NDArray
from torch import Tensor
from torch.utils.data import default_collate

from navtool.base.errors import NavtoolError
from navtool.train.checkpoint import LoadedRun
from navtool.train.errors import TrainError
from navtool.train.models import kind_of
from navtool.train.run_lineage import dataset_path, splits_of
from navtool.train.splits import Split

GOLDEN = "golden.safetensors"
TOLERANCE = 1e-5
"""Largest absolute difference of a probability from the golden one."""
SAMPLES = 3


class GoldenInputs(NamedTuple):
    """Inputs by name, and where they come from."""

    tensors: dict[str, Tensor]
    source: str


def golden_inputs(run: LoadedRun, where: Path) -> GoldenInputs:
    """Samples that the network was not trained on, from the run's data; made of numbers where they are out of reach.

    Args:
        run: The run.
        where: Its ``lineage.json``, for messages.
    """
    kind = kind_of(run.config.model)
    try:
        source = kind.task.open(dataset_path(run.lineage, where))
        splits = splits_of(run.lineage, source)
        samples = kind.task.samples(source, splits.episodes(Split.test) or splits.episodes(Split.val), run.config)
        if not len(samples):
            raise TrainError("the data set has no samples any more", where=source.root)
        chosen = np.unique(_evenly(len(samples))).tolist()
        name = f"data set rows {samples.row[chosen].tolist()}"
    except NavtoolError as error:
        samples = kind.task.samples(kind.stand_in(run.config.model), [0], run.config)
        chosen, name = _evenly(len(samples)).tolist(), f"synthetic ({error.what})"
    inputs = kind.inputs(default_collate([samples[index] for index in chosen]))
    specs = kind.contract(run.config.model).inputs
    return GoldenInputs({spec.name: tensor for spec, tensor in zip(specs, inputs, strict=True)}, name)


def _evenly(count: int) -> NDArray[np.int64]:
    return np.linspace(0, count - 1, SAMPLES).round().astype(np.int64)


def golden_bytes(inputs: Mapping[str, Tensor], outputs: Mapping[str, Tensor]) -> bytes:
    """The golden file's content."""
    tensors = {f"input.{name}": tensor for name, tensor in inputs.items()}
    tensors |= {f"output.{name}": tensor for name, tensor in outputs.items()}
    return safetensors.torch.save({name: tensor.contiguous() for name, tensor in tensors.items()})
