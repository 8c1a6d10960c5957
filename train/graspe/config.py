"""The sizes and choices of the GrASPE network."""

from dataclasses import dataclass, field
from pathlib import Path

from navtool.pipeline.feature_graph import FeatureGraphConfig
from navtool.train.model_config import ModelConfig
from navtool.train.success.windows import DataConfig


@dataclass(kw_only=True, slots=True)
class GraspeConfig(ModelConfig):
    """The network of GrASPE, section IV; defaults are the paper's where it names them."""

    graph: FeatureGraphConfig = field(default_factory=FeatureGraphConfig)
    """Nodes per encoder and the decay of the edges, eq. (6)."""
    horizon: int = 10
    """Predicted steps T, at least 1."""
    history: int = 50
    """Steps of the velocity history, at least 20: below that the dilated convolutions skip some."""
    image_height: int = 240
    """Height of the camera and the trajectory image, px, at least 48."""
    image_width: int = 320
    """Width of the camera and the trajectory image, px, at least 48."""
    v_max_mps: float = 2.0
    """Linear velocity that is scaled to 1, above 0."""
    omega_max_radps: float = 2.0
    """Angular velocity that is scaled to 1, above 0."""
    point_range_m: float = 20.0
    """Coordinate that is scaled to 1, above 0."""
    cbam_reduction: int = 16
    """The channel attention's hidden layer has channels / this many units, at least 1."""
    pretrained_image_weights: str | None = None
    """File with a torchvision ResNet18 state dict; None starts from random weights. Nothing is ever downloaded."""
    point_widths: list[int] = field(default_factory=lambda: [64, 64, 64, 128, 1024])
    """Channels of PointNet's shared layers, at least 2 of them."""
    point_hidden: list[int] = field(default_factory=lambda: [512, 256])
    """Units of the dense layers between PointNet's maximum and its features."""
    point_transform_widths: list[int] = field(default_factory=lambda: [64, 128, 256])
    """Channels of the shared layers of PointNet's transform networks; PointNet has 1,024 at the end, at 4x the cost."""
    point_transform_hidden: list[int] = field(default_factory=lambda: [128, 64])
    """Units of the dense layers of PointNet's transform networks."""
    point_input_transform: bool = True
    """Whether a transform network turns the cloud before the shared layers see it."""
    point_feature_transform: bool = False
    """Whether a second one maps the features after the second shared layer (costs much, gains little)."""
    velocity_channels: int = 16
    """Channels of each of the velocity encoder's four convolutions, at least 1."""
    trajectory_channels: list[int] = field(default_factory=lambda: [8, 16, 32])
    """Channels of the trajectory encoder's three convolutions."""
    graph_channels: int = 16
    """Channels of each graph layer (and attention head), at least 1; the paper has 16."""
    attention_heads: int = 1
    """Heads of the graph attention layer, at least 1."""
    attention_uses_edges: bool = True
    """Whether the edge weights enter the attention; if not, only the two graph convolutions see them."""
    self_loop_weight: float | None = None
    """Edge feature of a node's loop to itself in the attention, in [0, 1]; None takes the mean of its other edges."""
    dense_hidden: int = 128
    """Units between the two dense layers, at least 1."""
    dropout: float = 0.5
    """Dropout after the graph attention, in [0, 1)."""
    reliability_aware: bool = True
    """Whether reliability shapes the graph; if not (the paper's ablation), r = 1 for every pair."""

    def __post_init__(self) -> None:
        """Collect every fault of the configuration into one error."""
        faults = [
            f"{name}={value} must be at least {least}"
            for name, value, least in (
                ("horizon", self.horizon, 1),
                ("history", self.history, 20),
                ("image_height", self.image_height, 48),
                ("image_width", self.image_width, 48),
                ("cbam_reduction", self.cbam_reduction, 1),
                ("velocity_channels", self.velocity_channels, 1),
                ("graph_channels", self.graph_channels, 1),
                ("attention_heads", self.attention_heads, 1),
                ("dense_hidden", self.dense_hidden, 1),
            )
            if value < least
        ]
        faults += [
            f"{name}={value} must be above 0"
            for name, value in (
                ("v_max_mps", self.v_max_mps),
                ("omega_max_radps", self.omega_max_radps),
                ("point_range_m", self.point_range_m),
            )
            if not value > 0.0
        ]
        for name, widths, least in (
            ("point_widths", self.point_widths, 3 if self.point_feature_transform else 2),
            ("point_hidden", self.point_hidden, 0),
            ("point_transform_widths", self.point_transform_widths, 1),
            ("point_transform_hidden", self.point_transform_hidden, 0),
            ("trajectory_channels", self.trajectory_channels, 3),
        ):
            if len(widths) < least or any(width < 1 for width in widths):
                faults.append(f"{name}={widths} must hold at least {least} numbers, each at least 1")
        if len(self.trajectory_channels) != 3:
            faults.append(f"trajectory_channels={self.trajectory_channels} must hold 3 numbers, one a convolution")
        if not 0.0 <= self.dropout < 1.0:
            faults.append(f"dropout={self.dropout} must lie in [0, 1)")
        if self.self_loop_weight is not None and not 0.0 <= self.self_loop_weight <= 1.0:
            faults.append(f"self_loop_weight={self.self_loop_weight} must lie in [0, 1], or null for the mean")
        if faults:
            raise ValueError("GrASPE network: " + "; ".join(faults))

    def faults(self, data: DataConfig) -> list[str]:
        """Where the network's horizon or history is not that of the samples."""
        return [
            f"model.{ours} = {mine} differs from data.{theirs} = {other}; set both"
            for ours, mine, theirs, other in (
                ("horizon", self.horizon, "horizon_steps", data.horizon_steps),
                ("history", self.history, "history_steps", data.history_steps),
            )
            if mine != other
        ]

    def files(self) -> tuple[Path, ...]:
        """The pretrained weights, where there are any."""
        return () if self.pretrained_image_weights is None else (Path(self.pretrained_image_weights),)
