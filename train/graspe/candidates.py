"""Many candidate trajectories on one encoding of the sensors: that it gives the same, and what it costs."""

import torch
from torch import Tensor

from navtool.train.contract import Law, OnboardNetwork

CANDIDATES = 50
"""Candidate trajectories a tick whose latency is reported."""


def _gap(network: OnboardNetwork, inputs: tuple[Tensor, ...]) -> float:
    image, points, count, velocity, trajectory, reliability = inputs
    features = network.encode_sensors(image, points, count, velocity)
    turned = [trajectory.roll(shift, dims=0) for shift in range(3)]
    together = network.score_candidates(features, torch.stack(turned, dim=1), reliability)
    alone = [network(image, points, count, velocity, candidate, reliability) for candidate in turned]
    return float((together - torch.stack(alone, dim=1)).abs().max())


SAME_AS_ALONE = Law(_gap, "between candidates together and alone")
"""Many trajectories on one encoding get what each gets by itself."""


def tick(network: OnboardNetwork, inputs: tuple[Tensor, ...]) -> Tensor:
    """The scores of `CANDIDATES` trajectories on one encoding, encoding included."""
    image, points, count, velocity, trajectory, reliability = inputs
    features = network.encode_sensors(image, points, count, velocity)
    return network.score_candidates(features, trajectory[:, None].repeat(1, CANDIDATES, 1, 1, 1), reliability)
