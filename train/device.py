"""Choosing where a network runs."""

import torch

from navtool.train.config import Device
from navtool.train.errors import TrainError


def torch_device(device: Device) -> torch.device:
    """The device to run on; ``auto`` takes a GPU where there is one.

    Raises:
        TrainError: This machine does not have it.
    """
    available = {
        Device.cuda: torch.cuda.is_available(),
        Device.mps: torch.backends.mps.is_available(),
        Device.cpu: True,
    }
    if device is Device.auto:
        device = next(candidate for candidate, there in available.items() if there)
    if not available[device]:
        raise TrainError(
            f"this machine has no {device.value} device that torch can use",
            where="trainer.device",
            cure="set trainer.device=auto",
        )
    return torch.device(device.value)
