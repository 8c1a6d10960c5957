"""The configuration of a training run."""

import math
from dataclasses import dataclass, field
from enum import StrEnum

from navtool.base.setting_checks import outside
from navtool.base.setting_error import refuse
from navtool.pipeline.success_metrics import SuccessMetricsConfig
from navtool.train.model_config import ModelConfig
from navtool.train.splits import SplitConfig
from navtool.train.success.windows import DataConfig


class Device(StrEnum):
    """Where the network runs."""

    auto = "auto"
    """A GPU where there is one, else the CPU."""
    cpu = "cpu"
    cuda = "cuda"
    mps = "mps"


class Precision(StrEnum):
    """How the network computes in training and validation; weights and optimiser are float32 in both."""

    fp32 = "fp32"
    bf16 = "bf16"
    """bfloat16 autocast. Measure before use: on a CPU with avx512_bf16 but no AMX it trains slower than fp32."""


@dataclass(kw_only=True, slots=True)
class OptimizerConfig:
    """Adam; the settings are those of the success predictor's paper."""

    learning_rate: float = 0.002
    """Step size, above 0."""

    weight_decay: float = 0.00025
    """L2 penalty added to the gradient, >= 0."""

    def __post_init__(self) -> None:
        refuse(
            outside(self, 0, math.inf, "learning_rate", above=True, cure="the paper uses 0.002"),
            outside(self, 0, math.inf, "weight_decay", cure="the paper uses 0.00025"),
        )


@dataclass(kw_only=True, slots=True)
class TrainerConfig:
    """How long and on what a run trains."""

    epochs: int = 30
    """Passes over the training samples, >= 1. The success predictor's paper trains 1,000."""

    batch_size: int = 32
    """Samples a step, >= 2: batch normalisation cannot learn from one."""

    device: Device = Device.auto
    """Where the network runs."""

    precision: Precision = Precision.fp32
    """How the network computes."""

    channels_last: bool = False
    """Whether convolutions keep channels innermost in memory; the results agree to rounding."""

    workers: int = 0
    """Processes that prepare samples, >= 0; 0 prepares them in the training process."""

    gradient_clip: float | None = None
    """Largest norm of the gradient, above 0; None does not clip (as that paper)."""

    figure_samples: int = 4
    """Validation samples in TensorBoard's figure of predictions, >= 0; 0 draws none."""

    def __post_init__(self) -> None:
        refuse(
            outside(self, 1, math.inf, "epochs"),
            outside(self, 2, math.inf, "batch_size"),
            outside(self, 0, math.inf, "workers", "figure_samples"),
            outside(self, 0, math.inf, "gradient_clip", above=True, cure="null clips nothing"),
        )


@dataclass(kw_only=True, slots=True)
class TrainConfig:
    """Everything that a run depends on, its data set apart."""

    model: ModelConfig
    """The network; its class says which kind of model it is."""

    optimizer: OptimizerConfig = field(default_factory=OptimizerConfig)
    """How its weights move."""

    trainer: TrainerConfig = field(default_factory=TrainerConfig)
    """How long and on what."""

    data: DataConfig = field(default_factory=DataConfig)
    """What a sample is."""

    split: SplitConfig = field(default_factory=SplitConfig)
    """Which episodes train, validate and test."""

    metrics: SuccessMetricsConfig = field(default_factory=SuccessMetricsConfig)
    """How predictions are judged."""

    seed: int = 0
    """Seed of the weights, the order of samples and dropout, >= 0; on one machine, a CPU run is a function of it."""

    def __post_init__(self) -> None:
        refuse(self.model.faults(self.data), outside(self, 0, math.inf, "seed"))
