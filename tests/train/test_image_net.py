"""The camera encoder: ResNet18's weights, block attention in every block, normalisation inside."""

import pytest
import torch
from torch import Tensor
from torchvision.models import resnet18

from navtool.train.graspe.image_net import ImageNet
from navtool.train.layers.cbam import Cbam

pytestmark = pytest.mark.filterwarnings("ignore:.torch.jit.script. is deprecated:DeprecationWarning")


def some_images(height: int = 48, width: int = 64) -> Tensor:
    return torch.randint(0, 256, (3, 3, height, width), generator=torch.Generator().manual_seed(0), dtype=torch.uint8)


@pytest.mark.parametrize(("height", "width"), [(48, 64), (96, 33)])
def test_any_size_gives_features_in_the_open_unit_interval(height: int, width: int) -> None:
    torch.manual_seed(0)
    features = ImageNet(5)(some_images(height, width))
    assert features.shape == (3, 5)
    assert features.min().item() > 0.0
    assert features.max().item() < 1.0


def test_every_residual_block_ends_in_attention() -> None:
    net = ImageNet()
    assert sum(isinstance(module, Cbam) for module in net.modules()) == 8


def test_is_a_resnet18_on_normalised_pixels_where_the_attention_is_switched_off() -> None:
    torch.manual_seed(0)
    plain = resnet18(weights=None).eval()
    net = ImageNet(40).eval()
    net.load_backbone(plain.state_dict())
    backbone = net.backbone
    for block in (*backbone.layer1, *backbone.layer2, *backbone.layer3, *backbone.layer4):
        block.bn2[1] = torch.nn.Identity()
    plain.fc = net.backbone.fc
    mean, std = torch.tensor([0.485, 0.456, 0.406]), torch.tensor([0.229, 0.224, 0.225])
    images = some_images()
    normalised = (images / 255.0 - mean.view(3, 1, 1)) / std.view(3, 1, 1)
    torch.testing.assert_close(net(images), plain(normalised).sigmoid(), atol=1e-5, rtol=1e-4)


def test_load_backbone_takes_all_but_classifier_and_attention_and_refuses_other_networks() -> None:
    torch.manual_seed(0)
    donor, net = resnet18(weights=None).state_dict(), ImageNet()
    classifier = net.backbone.fc.weight.clone()
    net.load_backbone(donor)
    own = net.backbone.state_dict()
    for name, tensor in donor.items():
        if not name.startswith("fc."):
            where = name.replace("bn2.", "bn2.0.") if name.startswith("layer") else name
            assert torch.equal(own[where], tensor), name
    assert torch.equal(own["fc.weight"], classifier)
    del donor["conv1.weight"]
    with pytest.raises(RuntimeError, match=r"conv1\.weight"):
        net.load_backbone(donor)


def test_bfloat16_and_channels_last_stay_near_float32() -> None:
    torch.manual_seed(0)
    net = ImageNet().eval()
    images = some_images()
    expected = net(images)
    net.to(memory_format=torch.channels_last)  # type: ignore[call-overload] # missing in the stubs
    torch.testing.assert_close(net(images), expected, atol=1e-5, rtol=1e-4)
    with torch.autocast("cpu", dtype=torch.bfloat16):
        torch.testing.assert_close(net(images).float(), expected, atol=0.03, rtol=0.0)


def test_scripted_equals_eager() -> None:
    torch.manual_seed(0)
    net = ImageNet().eval()
    torch.testing.assert_close(torch.jit.script(net)(some_images()), net(some_images()), atol=1e-5, rtol=1e-5)
