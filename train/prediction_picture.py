"""A picture of what a run predicts on samples of a split."""

from io import BytesIO
from pathlib import Path

from navtool.train.checkpoint import load_run
from navtool.train.config import Device
from navtool.train.device import torch_device
from navtool.train.errors import TrainError
from navtool.train.models import kind_of, name_of
from navtool.train.predict import predict_samples
from navtool.train.run_lineage import splits_of
from navtool.train.splits import Split


def prediction_picture(run: Path, dataset: Path, split: Split = Split.test, count: int = 6) -> bytes:
    """Samples with what the network says of them, as a PNG.

    The samples are chosen by what is true of them, never by what is predicted.

    Args:
        run: The run's folder.
        dataset: Folder of the data set that it was trained on.
        split: Which episodes; not ``Split.all``.
        count: How many samples at most.

    Raises:
        TrainError: The run cannot be used, the split has no samples, or this kind of model has no picture.
        DatasetsError: The data set cannot be read.
    """
    loaded = load_run(run)
    kind = kind_of(loaded.config.model)
    task = kind.task
    if task.picture is None:
        raise TrainError(f"the model {name_of(loaded.config.model)} has no picture of its predictions", where=run)
    source = task.open(dataset)
    samples = task.samples(source, splits_of(loaded.lineage, source).episodes(split), loaded.config)
    if not len(samples):
        raise TrainError(f"the {split.value} split has no samples", where=run, cure="choose another split")
    chosen = [samples[index] for index in task.picture.choose(samples, count)]
    device = torch_device(Device.auto)
    output = predict_samples(kind, loaded.model.to(device), chosen, device)
    picture = BytesIO()
    task.picture.draw(chosen, output, loaded.config).savefig(picture, format="png", metadata={"Software": None})
    return picture.getvalue()
