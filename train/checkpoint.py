"""Reading the checkpoints of a run: tensors and plain values only, never code."""

import pickle
import warnings
from pathlib import Path
from typing import Any, NamedTuple

import torch
from torch import nn

from navtool.base.lineage import config_hash
from navtool.train.config import TrainConfig
from navtool.train.errors import TrainError
from navtool.train.models import kind_of, name_of
from navtool.train.run_folder import RunFolder

CHECKPOINT_SCHEMA = 1
"""Raised whenever the content of a checkpoint changes its meaning; other versions are refused."""

_PREFIX = "model."
_CURE = "resume or repeat the run that wrote it"


class LoadedRun(NamedTuple):
    """A trained network and what it came from."""

    model: nn.Module
    """In evaluation mode, on the CPU."""
    config: TrainConfig
    """The run's configuration."""
    lineage: dict[str, Any]
    """The run's ``lineage.json``."""


def load_run(run: Path, checkpoint: str = "best") -> LoadedRun:
    """The network of a run.

    Args:
        run: The run's folder.
        checkpoint: ``best`` (smallest validation loss) or ``last``.

    Raises:
        TrainError: There is no run or no such checkpoint, or it belongs to another configuration.
        DatasetsError: A JSON file of the run is missing or damaged.
    """
    folder = RunFolder(run)
    config = folder.read_config()
    lineage = folder.read_lineage()
    path = folder.checkpoints / f"{checkpoint}.ckpt"
    content = read_checkpoint(path)
    check_stamp(content, path, config)
    model = kind_of(config.model).build(config.model)
    try:
        state = content["state_dict"]
        model.load_state_dict({name.removeprefix(_PREFIX): tensor for name, tensor in state.items()})
    except (KeyError, AttributeError, TypeError, RuntimeError) as error:
        first = str(error).strip().split("\n")[0]
        raise TrainError(f"does not hold the network of config.json ({first})", where=path, cure=_CURE) from error
    return LoadedRun(model.eval(), config, lineage)


def read_checkpoint(path: Path) -> dict[str, Any]:
    """The content of a checkpoint file, on the CPU. Nothing in the file is executed.

    Raises:
        TrainError: The file is missing, damaged, or holds anything but tensors and plain values.
    """
    if not path.is_file():
        cure = "train until an epoch is complete, or resume the run"
        raise TrainError("no such checkpoint", where=path, cure=cure)
    try:
        with warnings.catch_warnings(action="ignore"):  # its doubts about a foreign pickle; ours is an error
            content = torch.load(path, map_location="cpu", weights_only=True)
    except pickle.UnpicklingError as error:
        raise TrainError(
            "holds more than tensors and plain values; it was not loaded, as a pickle can run any code",
            where=path,
            cure="use a checkpoint that navtool wrote",
        ) from error
    except (RuntimeError, ValueError, EOFError, OSError, KeyError, IndexError, AttributeError, TypeError) as error:
        first = str(error).strip().split("\n")[0]
        raise TrainError(f"is damaged ({first})", where=path, cure=_CURE) from error
    if not isinstance(content, dict):
        raise TrainError("is not a checkpoint of navtool", where=path, cure="use a checkpoint that navtool wrote")
    return content


def check_stamp(content: dict[str, Any], path: Path, config: TrainConfig) -> None:
    """Make sure that a checkpoint belongs to a run of this network.

    Raises:
        TrainError: It does not.
    """
    stamp = content.get("navtool")
    if not isinstance(stamp, dict):
        raise TrainError("is not a checkpoint of navtool", where=path, cure="use a checkpoint that navtool wrote")
    wanted = checkpoint_stamp(config)
    for name, value in wanted.items():
        if stamp.get(name) != value:
            raise TrainError(
                f"{name} of the checkpoint is {stamp.get(name)!r}, the run's is {value!r}", where=path, cure=_CURE
            )


def checkpoint_stamp(config: TrainConfig) -> dict[str, Any]:
    """What a checkpoint says of itself."""
    name, network = name_of(config.model), config_hash(config.model)
    return {"schema_version": CHECKPOINT_SCHEMA, "model": name, "network_hash": network}
