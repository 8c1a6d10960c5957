"""A picture of what a run predicts on samples of a split, half of them with failures ahead."""

from dataclasses import replace
from io import BytesIO
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from navtool.datasets.store.reader import NavDataset
from navtool.train.checkpoint import load_run
from navtool.train.config import Device
from navtool.train.datamodule import sample_loader
from navtool.train.device import torch_device
from navtool.train.errors import TrainError
from navtool.train.figure import prediction_figure
from navtool.train.predictions import predict
from navtool.train.run_lineage import splits_of
from navtool.train.samples import SampleDataset
from navtool.train.splits import Split
from navtool.train.windows import Windows, plan_windows


def prediction_picture(run: Path, dataset: Path, split: Split = Split.test, count: int = 6) -> bytes:
    """Camera images with the predicted trajectory, and below them E-hat against E, as a PNG.

    The samples are chosen by what is true of them, never by what is predicted: half of them with a failure ahead, as
    far as there are any, evenly over the split.

    Args:
        run: The run's folder.
        dataset: Folder of the data set that it was trained on.
        split: Which episodes; not ``Split.all``.
        count: How many samples at most.

    Raises:
        TrainError: The run cannot be used, or the split has no samples.
        DatasetsError: The data set cannot be read.
    """
    loaded, source = load_run(run), NavDataset(dataset)
    windows = plan_windows(source, splits_of(loaded.lineage, source).episodes(split), loaded.config.data)
    if not len(windows):
        raise TrainError(f"the {split.value} split has no samples", where=run, cure="choose another split")
    samples = SampleDataset(source, some_windows(windows, count), loaded.config.data)
    loader = sample_loader(samples, loaded.config.trainer.batch_size, workers=0)
    device = torch_device(Device.auto)
    predictions = predict(loaded.model.to(device), loader, device)
    picture = BytesIO()
    prediction_figure(
        [samples[index] for index in range(len(samples))],
        predictions.probability,
        success_threshold=loaded.config.metrics.success_threshold,
    ).savefig(picture, format="png", metadata={"Software": None})
    return picture.getvalue()


def some_windows(windows: Windows, count: int) -> Windows:
    """Samples with a known failure ahead and others, in the order of the rows."""
    fails = (windows.known & (windows.target == 0.0)).any(axis=1)
    failing, fine = np.flatnonzero(fails), np.flatnonzero(~fails)
    most = max(count // 2, count - fine.size)
    few = _evenly(failing, min(most, failing.size))
    chosen = np.sort(np.concatenate([few, _evenly(fine, min(count - few.size, fine.size))]))
    arrays = {name: getattr(windows, name)[chosen] for name in ("row", "episode", "first_row", "target", "known")}
    return replace(windows, **arrays)


def _evenly(indices: NDArray[np.int64], count: int) -> NDArray[np.int64]:
    return np.asarray(indices[np.linspace(0, indices.size - 1, count).round().astype(np.int64)])
