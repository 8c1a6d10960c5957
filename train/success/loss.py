"""The training loss: squared error over the steps whose outcome is known."""

import torch
from torch import Tensor


def masked_mse(prediction: Tensor, target: Tensor, known: Tensor) -> Tensor:
    r"""Return the mean squared error over the known entries.

    .. math::
        L = \frac{\sum_{b,k} m_{bk} (\hat e_{bk} - e_{bk})^2}{\max(1, \sum_{b,k} m_{bk})}

    The mask m marks steps whose outcome is known.

    Guarantees:
        Unknown entries change neither the value nor the gradient, NaN targets included; a batch without any known
        entry gives 0 and zero gradients. Computed in float32.

    Shape:
        prediction, target: [B, T]; known: [B, T] bool; result: scalar.
    """
    error = torch.where(known, prediction.float() - target.float(), 0.0)
    return error.square().sum() / known.sum().clamp(min=1)
