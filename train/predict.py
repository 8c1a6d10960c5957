"""What a network says about samples."""

from collections.abc import Callable, Iterable, Sequence

import torch
from torch.utils.data import default_collate

from navtool.train.judgement import Judge, Judgement
from navtool.train.samples import Batch


def predict[OutputT](score: Callable[..., OutputT], batch: Batch, device: torch.device) -> OutputT:
    """The network's output for a batch, without gradients; it must be in evaluation mode already."""
    with torch.inference_mode():
        return score(*(tensor.to(device) for tensor in batch.inputs()))


def predict_samples[OutputT](score: Callable[..., OutputT], samples: Sequence[Batch], device: torch.device) -> OutputT:
    """`predict` for samples that are not batched yet."""
    batch: Batch = default_collate(list(samples))
    return predict(score, batch, device)


def judge_batches[BatchT: Batch, OutputT](
    score: Callable[..., OutputT], batches: Iterable[BatchT], judge: Judge[BatchT, OutputT], device: torch.device
) -> Judgement:
    """The figures of a network over all batches; it must be in evaluation mode already."""
    for batch in batches:
        judge.add(batch, predict(score, batch, device))
    return judge.result()
