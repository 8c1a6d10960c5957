"""Golden inputs and the output that the network gave for them when it was exported."""

from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np
import safetensors.torch
import torch
from torch import Tensor

from navtool.base.navtool_error import NavtoolError
from navtool.datasets.store.reader import NavDataset
from navtool.export.manifest import TensorSpec
from navtool.train.checkpoint import LoadedRun
from navtool.train.datamodule import sample_loader
from navtool.train.errors import TrainError
from navtool.train.run_lineage import dataset_path, splits_of
from navtool.train.samples import SampleDataset
from navtool.train.splits import Split
from navtool.train.synthetic import SyntheticConfig, SyntheticSource
from navtool.train.windows import plan_windows

GOLDEN = "golden.safetensors"
TOLERANCE = 1e-5
"""Largest absolute difference of a probability from the golden one."""
SAMPLES = 3


class GoldenInputs(NamedTuple):
    """Inputs by name, and where they come from."""

    tensors: dict[str, Tensor]
    source: str


def golden_inputs(run: LoadedRun, where: Path, inputs: tuple[TensorSpec, ...]) -> GoldenInputs:
    """Samples that the network was not trained on, from the run's data set; synthetic ones where it is out of reach.

    Args:
        run: The run.
        where: Its ``lineage.json``, for messages.
        inputs: Names of the inputs in the order of `Sample.inputs`.
    """
    try:
        source = NavDataset(dataset_path(run.lineage, where))
        splits = splits_of(run.lineage, source)
        windows = plan_windows(source, splits.episodes(Split.test) or splits.episodes(Split.val), run.config.data)
        if not len(windows):
            raise TrainError("the data set has no samples any more", where=source.root)
        chosen = np.unique(np.linspace(0, len(windows) - 1, SAMPLES).round().astype(np.int64)).tolist()
        dataset, name = SampleDataset(source, windows, run.config.data), f"data set rows {windows.row[chosen].tolist()}"
    except NavtoolError as error:
        model = run.config.model
        world = SyntheticConfig(rows=30, image_height=model.image_height, image_width=model.image_width)
        fallback = SyntheticSource(world)
        windows = plan_windows(fallback, [0], run.config.data)
        chosen = np.linspace(0, len(windows) - 1, SAMPLES).round().astype(np.int64).tolist()
        dataset, name = SampleDataset(fallback, windows, run.config.data), f"synthetic ({error.what})"
    batch = next(iter(sample_loader(torch.utils.data.Subset(dataset, chosen), SAMPLES, workers=0)))
    return GoldenInputs({spec.name: tensor for spec, tensor in zip(inputs, batch.inputs(), strict=True)}, name)


def golden_bytes(inputs: Mapping[str, Tensor], outputs: Mapping[str, Tensor]) -> bytes:
    """The golden file's content."""
    tensors = {f"input.{name}": tensor for name, tensor in inputs.items()}
    tensors |= {f"output.{name}": tensor for name, tensor in outputs.items()}
    return safetensors.torch.save({name: tensor.contiguous() for name, tensor in tensors.items()})
