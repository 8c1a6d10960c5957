"""A picture of what a network predicts: the camera image with the trajectory, and E-hat against E."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from navtool.train.success.samples import Sample


def prediction_figure(
    samples: Sequence[Sample], probability: NDArray[np.float32], *, success_threshold: float
) -> Figure:
    """One column a sample: above the image with the swath tinted, below the probabilities over the horizon.

    Args:
        samples: At least one, not batched.
        probability: E-hat of each, (n, T).
        success_threshold: e_th, drawn as a line.
    """
    figure = Figure(figsize=(3.2 * len(samples), 4.6), dpi=80, layout="constrained")
    axes = figure.subplots(2, len(samples), squeeze=False, height_ratios=(1.0, 0.8))
    for column, sample in enumerate(samples):
        _draw_image(axes[0, column], sample)
        _draw_steps(axes[1, column], sample, probability[column], success_threshold)
    axes[1, 0].set_ylabel("success")
    axes[1, -1].legend(fontsize="x-small", loc="lower left")
    return figure


def _draw_image(axes: Axes, sample: Sample) -> None:
    image = sample.image.permute(1, 2, 0).numpy().astype(np.float32) / 255.0
    swath = sample.trajectory[0].numpy()[..., None] > 0
    tinted = np.where(swath, 0.6 * image + 0.4 * np.array([0.1, 0.9, 0.3]), image)
    axes.imshow(tinted, interpolation="nearest")
    axes.set_axis_off()
    r_img, r_point = sample.reliability.tolist()
    axes.set_title(f"row {int(sample.row)}: r_img {r_img:.2f}, r_point {r_point:.2f}", fontsize="small")


def _draw_steps(axes: Axes, sample: Sample, probability: NDArray[np.float32], threshold: float) -> None:
    steps = np.arange(len(probability))
    known = sample.known.numpy()
    axes.axhline(threshold, color="0.7", linewidth=1.0, label="e_th")
    axes.plot(steps, probability, marker="o", markersize=3.0, label="predicted")
    axes.plot(steps[known], sample.target.numpy()[known], "x", color="black", label="true, where known")
    axes.set_ylim(-0.05, 1.05)
    axes.set_xlabel("step")
