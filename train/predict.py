"""What a network says about samples."""

from collections.abc import Callable, Sequence
from typing import Any

import torch
from torch import Tensor
from torch.utils.data import default_collate

from navtool.train.model_kind import AnyKind
from navtool.train.samples import Batch


def predict[OutputT](score: Callable[..., OutputT], inputs: Sequence[Tensor], device: torch.device) -> OutputT:
    """The network's output, without gradients; it must be in evaluation mode already."""
    with torch.inference_mode():
        return score(*(tensor.to(device) for tensor in inputs))


def predict_samples(kind: AnyKind, network: Callable[..., Any], samples: Sequence[Batch], device: torch.device) -> Any:
    """`predict` for samples that are not batched yet."""
    return predict(network, kind.inputs(default_collate(list(samples))), device)
