"""The camera encoder: ResNet18 with block attention."""

from collections.abc import Mapping
from typing import Any

import torch
from torch import Tensor, nn
from torchvision.models import resnet18

from navtool.train.layers.cbam import Cbam


class ImageNet(nn.Module):
    """Image features in (0, 1) from a ResNet18 whose residual branches end in CBAM.

    Reference: GrASPE, section IV-B.1; CBAM, fig. 3 (attention after a block's last batch norm, before the addition).

    Args:
        features: Size of the feature vector.
        reduction: Of the channel attention.

    Shape:
        image: [B, 3, H, W] uint8 RGB, any size from 32 px on; result: [B, features].

    Note:
        The image is scaled to [0, 1], then by ImageNet's mean and standard deviation, as pretrained weights expect.
    """

    scale: Tensor
    shift: Tensor

    def __init__(self, features: int = 40, *, reduction: int = 16) -> None:
        super().__init__()
        self.backbone = resnet18(weights=None)
        for stage in self._stages():
            for block in stage:
                block.bn2 = nn.Sequential(block.bn2, Cbam(block.bn2.num_features, reduction=reduction))
        self.backbone.fc = nn.Linear(self.backbone.fc.in_features, features)
        mean = torch.tensor([0.485, 0.456, 0.406]).view(1, 3, 1, 1)
        std = torch.tensor([0.229, 0.224, 0.225]).view(1, 3, 1, 1)
        self.register_buffer("scale", 1.0 / (255.0 * std))
        self.register_buffer("shift", -mean / std)

    def forward(self, image: Tensor) -> Tensor:
        """Return the feature vectors."""
        normalised = torch.addcmul(self.shift, image.to(self.scale.dtype), self.scale)
        features: Tensor = self.backbone(normalised).sigmoid()
        return features

    def load_backbone(self, state: Mapping[str, Tensor]) -> None:
        """Take the weights of a plain torchvision ResNet18; its classifier is left out, the attention keeps its own.

        Raises:
            RuntimeError: Keys or shapes are not those of a ResNet18.
        """
        plain = {name: tensor for name, tensor in state.items() if not name.startswith("fc.")}
        # Inside each block the batch norm now is the first of two modules.
        renamed = {name.replace("bn2.", "bn2.0.") if name.startswith("layer") else name: plain[name] for name in plain}
        own: dict[str, Any] = self.backbone.state_dict()
        kept = {name: tensor for name, tensor in own.items() if name.startswith("fc.") or ".bn2.1." in name}
        self.backbone.load_state_dict({**renamed, **kept}, strict=True)

    def _stages(self) -> list[Any]:
        return [self.backbone.layer1, self.backbone.layer2, self.backbone.layer3, self.backbone.layer4]
