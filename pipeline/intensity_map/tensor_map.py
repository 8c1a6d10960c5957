"""Intensity maps of a batch of clouds on the processor or the graphics card (MIM, eq. 1 to 5 and 8 to 11)."""

import math
from typing import NamedTuple

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn import functional

from navtool.pipeline.intensity_map.config import FlatLayers, Inflation, IntensityMapConfig
from navtool.pipeline.intensity_map.layer_points import Layer, ground_blocks, ground_limits
from navtool.pipeline.intensity_map.obstacles import TIE, CellClass
from navtool.pipeline.scripting import no_type_check


class TensorMap(NamedTuple):
    """The maps of B clouds; r along x, c along y."""

    total: Tensor
    """Sums of intensities in units of R, [B, 4, n, n] float32."""
    points: Tensor
    """Numbers of points, [B, 4, n, n] float32."""
    solid: Tensor
    """I_TP, [B, n, n] float32."""
    pliable: Tensor
    """I_FP, [B, n, n] float32."""
    classes: Tensor
    """A `CellClass` for each cell, [B, n, n] uint8."""
    plan: Tensor
    """I_plan, [B, n, n] float32."""


class TensorIntensityMap(nn.Module):
    """What `map_cloud` computes of a cloud, for a batch: layers, classes, inflation and plan; TorchScript compiles it.

    The classes are those of the NumPy path, the values equal up to the rounding of sums. Panes are found there alone:
    the cells that are known to be transparent come in as a mask.
    """

    from_above: Tensor
    ground_limits: Tensor

    def __init__(self, config: IntensityMapConfig) -> None:
        super().__init__()
        grid, layers, inflation = config.grid, config.layers, config.inflation
        self.cells = grid.cells
        self.blocks = ground_blocks(grid)
        self.half_m = _single(grid.half_m)
        self.cells_per_m = _single(1 / grid.cell_m)
        self.area_m2 = _single(grid.cell_m * grid.cell_m)
        self.height_m = _single(layers.height_m)
        self.angular = layers.flat is FlatLayers.angular
        self.level = _single(math.tan(layers.flat_rad) if self.angular else layers.flat_m)
        self.below = _single(math.tan(3 * layers.flat_rad) if self.angular else 3 * layers.flat_m)
        self.sensor_height_m = _single(layers.sensor_height_m)
        self.ground_margin_m = _single(layers.ground_margin_m)
        self.of_full_scale = _single(1 / layers.full_scale)
        self.reduction = layers.reduction.value
        self.threshold = _single(config.obstacles.threshold)
        self.excess = _single(config.obstacles.threshold * grid.cell_m * grid.cell_m)
        self.tie = _single(TIE)
        self.pooling = config.obstacles.pooling_cells
        self.pliable = int(CellClass.pliable)
        self.solid = int(CellClass.solid)
        self.transparent = int(CellClass.transparent)
        self.adaptive = inflation.method is Inflation.adaptive
        self.reach = (inflation.size_cells - 1) // 2
        self.padding = inflation.padding_cells
        self.minor = inflation.minor_cells
        from_above = [int(Layer.upper), int(Layer.level), int(Layer.below), int(Layer.lower)]
        self.register_buffer("from_above", torch.tensor(from_above), persistent=False)
        limits = torch.from_numpy(ground_limits(grid, layers))
        self.register_buffer("ground_limits", limits, persistent=False)

    @no_type_check
    def forward(
        self, xyz: Tensor, intensity: Tensor, counts: Tensor, goal_rad: Tensor, transparent: Tensor
    ) -> TensorMap:
        """Map each cloud.

        Args:
            xyz: Points in the frame of the sensor, in metres; any that are not finite count for nothing.
            intensity: Of each point, 0 to R.
            counts: How many of its P points each cloud has; those behind are padding.
            goal_rad: Direction of each goal, in the frame of the sensor.
            transparent: The cells known to be glass.

        Shape:
            xyz: [B, P, 3]; intensity: [B, P]; counts, goal_rad: [B]; transparent: [B, n, n] bool.
        """
        total, points, largest = self.layers(xyz.float(), intensity.float(), counts)
        seen = (points > 0).any(dim=1)  # [B, n, n]
        if self.reduction == "sum":
            value = total / self.area_m2  # eq. 1
        elif self.reduction == "mean":
            value = total / points.clamp(min=1.0)
        else:
            value = largest
        highest = value.amax(dim=1)
        above = self._above(total, points, value)  # [B, n, n]
        nothing = torch.zeros_like(highest)
        solid, pliable = torch.where(above, highest, nothing), torch.where(above, nothing, highest)  # eq. 4 and 5
        classes = seen.to(torch.uint8) * self.pliable
        classes = classes.masked_fill(transparent, self.transparent).masked_fill(solid > 0, self.solid)
        hard = torch.where(transparent, solid.clamp(min=1.0), solid)
        plan = torch.maximum(self._inflated(hard, goal_rad), pliable)  # eq. 11
        return TensorMap(total, points, solid, pliable, classes, plan)

    @no_type_check
    def layers(self, xyz: Tensor, intensity: Tensor, counts: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """Sum, number and largest of the intensities in each cell, [B, 4, n, n] each."""
        batch, size, n = xyz.shape[0], xyz.shape[1], self.cells
        x, y, z = xyz.unbind(dim=2)  # [B, P]
        half = self.half_m
        real = torch.arange(size, device=xyz.device).unsqueeze(0) < counts.unsqueeze(1)
        in_grid = (x >= -half) & (x < half) & (y >= -half) & (y < half)
        chosen = real & in_grid & (z.abs() <= self.height_m) & intensity.isfinite()
        number = torch.arange(batch, device=xyz.device).unsqueeze(1)  # [B, 1]
        # what is not chosen is put in the middle, so that it can be counted among its cell's points as nothing
        zero = torch.zeros_like(x)
        if self.ground_margin_m > 0:
            low = real & in_grid & z.isfinite()
            bx, by = torch.where(in_grid, x, zero), torch.where(in_grid, y, zero)
            last = self.blocks - 1
            row, column = (bx + half).long().clamp(max=last), (by + half).long().clamp(max=last)
            block = (number * self.blocks + row) * self.blocks + column  # [B, P]
            lowest = torch.full((batch * self.blocks * self.blocks,), float("inf"), device=xyz.device)
            depth = torch.where(low, z, torch.full_like(z, float("inf")))
            lowest = lowest.scatter_reduce(0, block.flatten(), depth.flatten(), "amin")
            lowest = lowest.view(batch, 1, self.blocks, self.blocks)
            lowest = lowest.masked_fill(lowest >= self.ground_limits, float("inf"))
            around = -functional.max_pool2d(-lowest, 3, 1, 1)
            opened = functional.max_pool2d(torch.where(lowest.isinf(), -lowest, around), 3, 1, 1)
            nothing = torch.full_like(around, -self.sensor_height_m)
            ground = torch.where(around.isinf(), nothing, opened)
            chosen = chosen & (z > ground.flatten()[block] + self.ground_margin_m)
        x, y, z = torch.where(chosen, x, zero), torch.where(chosen, y, zero), torch.where(chosen, z, zero)
        share = (torch.where(chosen, intensity, zero) * self.of_full_scale).clamp(0.0, 1.0)
        scale, middle = self.cells_per_m, 0.5 * n
        row, column = (x * scale + middle).long().clamp(0, n - 1), (y * scale + middle).long().clamp(0, n - 1)
        cell = (((number * 4 + self._layer_of(x, y, z)) * n + row) * n + column).flatten()
        total = torch.zeros(batch * 4 * n * n, device=xyz.device)
        points = total.index_add(0, cell, chosen.flatten().float()).view(batch, 4, n, n)
        largest = total.scatter_reduce(0, cell, share.flatten(), "amax").view(batch, 4, n, n)
        total = total.index_add(0, cell, share.flatten()).view(batch, 4, n, n)
        return total, points, largest

    @no_type_check
    def _layer_of(self, x: Tensor, y: Tensor, z: Tensor) -> Tensor:
        """The layer of each point within h of the sensor's height, [B, P]."""
        if self.angular:
            reach = (x * x + y * y).sqrt()
            level, below = reach * self.level, reach * self.below
        else:
            level, below = torch.full_like(z, self.level), torch.full_like(z, self.below)
        return self.from_above[(z <= level).long() + (z < -level).long() + (z < -below).long()]

    @no_type_check
    def _above(self, total: Tensor, points: Tensor, value: Tensor) -> Tensor:
        """Where the reduction of the points around is above the threshold in any layer, eq. 3, [B, n, n]."""
        side = 2 * self.pooling + 1
        if self.pooling == 0:
            return (value > self.threshold).any(dim=1)
        if self.reduction == "max":
            pooled = functional.max_pool2d(value, side, 1, self.pooling)
            return (pooled > self.threshold).any(dim=1)
        excess = total - points * self.threshold if self.reduction == "mean" else total - self.excess
        # sums over rows, then over columns; beyond the edge there is nothing
        k = self.pooling
        layers = excess.flatten(0, 1).unsqueeze(1)  # [B 4, 1, n, n]
        ones = torch.ones(1, 1, side, 1, device=excess.device)
        pooled = functional.conv2d(layers, ones, None, [1, 1], [k, 0])
        pooled = functional.conv2d(pooled, ones.transpose(2, 3), None, [1, 1], [0, k])
        return (pooled.view_as(excess) > self.tie).any(dim=1)

    @no_type_check
    def _inflated(self, hard: Tensor, goal_rad: Tensor) -> Tensor:
        """The convolution of eq. 10 with each cloud's own kernel, [B, n, n]."""
        side, reach = 2 * self.reach + 1, self.reach
        kernel = torch.ones(hard.shape[0], side, side, device=hard.device)
        if self.adaptive:
            axis = torch.arange(-reach, reach + 1, device=hard.device, dtype=torch.float64)
            x, y = axis.view(1, -1, 1), axis.view(1, 1, -1)
            cosine = goal_rad.double().cos().view(-1, 1, 1)
            sine = goal_rad.double().sin().view(-1, 1, 1)
            back, aside = -(x * cosine + y * sine), (y * cosine - x * sine).abs()
            disc = (x * x + y * y).sqrt() <= self.minor + 1e-9
            kernel = (((back > -0.5) & (aside <= self.padding + 0.5)) | disc).float()  # [B, e, e], eq. 9
        # conv2d correlates
        turned = kernel.flip([1, 2]).unsqueeze(1)  # [B, 1, e, e]
        grown = functional.conv2d(hard.unsqueeze(0), turned, None, [1, 1], [reach, reach], [1, 1], hard.shape[0])
        return grown.squeeze(0)


def _single(value: float) -> float:
    """Rounded as the NumPy path rounds what meets points, so that both draw the same lines."""
    return float(np.float32(value))
