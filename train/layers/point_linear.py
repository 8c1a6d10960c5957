"""One layer of a shared point MLP: the same linear map for every point, batch norm, ReLU, and a maximum over points."""

import torch
from torch import Tensor, nn
from torch.nn import functional


class PointLinear(nn.Module):
    r"""Linear map and batch norm of many points, folded into one affine map before it is applied.

    The map is linear, so the batch statistics of its output follow from those of its input:

    .. math::
        \mu_h = W \mu_x, \qquad \sigma^2_h = \operatorname{diag}(W \operatorname{Cov}(x) W^\top), \qquad
        W' = \gamma \sigma_h^{-1} W, \quad b' = \beta - \gamma \sigma_h^{-1} \mu_h

    Neither the normalised output nor, in `max_over_points`, the output itself has to be kept for the backward pass:
    10,000 points of 1,024 channels are 41 MB a sample and tensor otherwise.

    Guarantees:
        Equal to ``Linear(bias=False)``, ``BatchNorm1d`` and ``ReLU`` in values, gradients and running statistics.
        Without any point the running statistics stand in for the batch's.

    Args:
        in_channels: Channels of each point.
        out_channels: Channels of each point afterwards.
        momentum: Share of the newest batch in the running statistics.
        eps: Added to the variance.

    Shape:
        x: [M, in_channels], the points of all samples one after another; result: [M, out_channels], at least 0.
    """

    running_mean: Tensor
    running_var: Tensor

    def __init__(self, in_channels: int, out_channels: int, *, momentum: float = 0.1, eps: float = 1e-5) -> None:
        super().__init__()
        self.momentum = momentum
        self.eps = eps
        self.block = 16  # points that share one maximum while the winning points are searched
        self.chunk = 1024  # points mapped at a time: a multiple of the block whose output stays in the cache
        self.weight = nn.Parameter(torch.empty(out_channels, in_channels))
        self.gamma = nn.Parameter(torch.ones(out_channels))
        self.beta = nn.Parameter(torch.zeros(out_channels))
        self.register_buffer("running_mean", torch.zeros(out_channels))
        self.register_buffer("running_var", torch.ones(out_channels))
        nn.init.kaiming_uniform_(self.weight, nonlinearity="relu")

    def forward(self, x: Tensor) -> Tensor:
        """Return each point's new channels."""
        weight, bias = self.folded(x)
        return functional.linear(x, weight, bias).relu_()

    def max_over_points(self, x: Tensor, counts: list[int]) -> Tensor:
        """Return the largest value of each channel over the points of each sample, [B, out_channels].

        Args:
            x: [M, in_channels].
            counts: Points of each sample, their sum is M; a sample without points gets zeros.
        """
        weight, bias = self.folded(x)
        pooled = [self._max(points, weight, bias) for points in torch.split(x, counts)]
        return functional.relu(torch.stack(pooled))  # ReLU and maximum commute

    def _max(self, points: Tensor, weight: Tensor, bias: Tensor) -> Tensor:
        if points.shape[0] == 0:
            return torch.zeros_like(bias)
        if torch.is_grad_enabled():
            # Only the winning points have a gradient: find them without one, then map those again.
            winners = points[self._winners(points.detach(), weight.detach())].float()  # [out, in]
            return (winners * weight).sum(dim=1) + bias
        maxima = [functional.linear(chunk, weight).amax(dim=0) for chunk in torch.split(points, self.chunk)]
        return torch.stack(maxima).amax(dim=0).float() + bias

    def _winners(self, points: Tensor, weight: Tensor) -> Tensor:
        """Return for each output channel the index of the point with the largest value, [out]."""
        if points.shape[0] <= self.chunk:
            return functional.linear(points, weight).argmax(dim=0)
        missing = -points.shape[0] % self.block
        padded = points if missing == 0 else torch.cat([points, points[:1].expand(missing, -1)])
        # Maxima of blocks are cheap (a vectorised pass over values still in the cache), an argmax of all is not.
        maxima = [
            functional.linear(chunk, weight).view(-1, self.block, weight.shape[0]).amax(dim=1)
            for chunk in torch.split(padded, self.chunk)
        ]
        block = torch.cat(maxima).argmax(dim=0)  # [out]
        candidates = padded.view(-1, self.block, points.shape[1])[block]  # [out, block, in]
        within = (candidates @ weight.to(candidates.dtype).unsqueeze(2)).squeeze(2).argmax(dim=1)  # [out]
        winner = block * self.block + within
        return torch.where(winner < points.shape[0], winner, 0)  # the padding repeats the first point

    def folded(self, x: Tensor) -> tuple[Tensor, Tensor]:
        """Return the affine map (weight, bias) that includes the batch norm, and update the running statistics."""
        with torch.autocast(device_type="cpu", enabled=False), torch.autocast(device_type="cuda", enabled=False):
            if self.training and x.shape[0] > 0:
                mean, var = self._output_statistics(x.float())
            else:
                mean, var = self.running_mean, self.running_var
            scale = self.gamma * (var + self.eps).rsqrt()
            weight = self.weight * scale.unsqueeze(1)
            bias = self.beta - mean * scale
        return weight, bias

    def _output_statistics(self, x: Tensor) -> tuple[Tensor, Tensor]:
        points = x.shape[0]
        mean_x = x.mean(dim=0)
        second = x.detach().t() @ x  # [in, in]; its gradient is symmetric, so one factor can carry all of it
        covariance = (2.0 * second - second.detach()) / points - torch.outer(mean_x, mean_x)
        mean = self.weight @ mean_x
        var = ((self.weight @ covariance) * self.weight).sum(dim=1).clamp(min=0.0)
        with torch.no_grad():
            unbiased = var * (points / max(points - 1, 1))
            self.running_mean.lerp_(mean, self.momentum)
            self.running_var.lerp_(unbiased, self.momentum)
        return mean, var
