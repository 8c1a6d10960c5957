"""The whole network: raw sensors in, probabilities out; candidates, scripting, precision, pretrained weights."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import torch
from torch import Tensor
from torchvision.models import resnet18

from navtool.pipeline.feature_graph import FeatureGraphConfig
from navtool.train.errors import TrainError
from navtool.train.graspe.config import GraspeConfig
from navtool.train.graspe.graspe import Graspe
from navtool.train.success.loss import masked_mse

pytestmark = pytest.mark.filterwarnings("ignore:.torch.jit.(script|save|load|freeze). is deprecated:DeprecationWarning")

jit: Any = torch.jit  # parts of it carry no types

BATCH, CANDIDATES, HEIGHT, WIDTH = 3, 4, 48, 64

Inputs = tuple[Tensor, Tensor, Tensor, Tensor, Tensor, Tensor]


def small_net(seed: int = 0, **options: Any) -> Graspe:
    torch.manual_seed(seed)
    small: dict[str, Any] = {
        "point_widths": [8, 16],
        "point_hidden": [8],
        "point_transform_widths": [8, 16],
        "point_transform_hidden": [8],
    }
    return Graspe(GraspeConfig(image_height=HEIGHT, image_width=WIDTH, **{**small, **options}))


def raw_inputs(seed: int = 1) -> Inputs:
    generator = torch.Generator().manual_seed(seed)
    return (
        torch.randint(0, 256, (BATCH, 3, HEIGHT, WIDTH), generator=generator, dtype=torch.uint8),
        torch.randn(BATCH, 40, 3, generator=generator) * 5.0,
        torch.tensor([40, 0, 13]),
        torch.randn(BATCH, 50, 2, generator=generator),
        torch.randint(0, 2, (BATCH, 1, HEIGHT, WIDTH), generator=generator, dtype=torch.uint8) * 255,
        torch.rand(BATCH, 2, generator=generator),
    )


def many_trajectories() -> Tensor:
    generator = torch.Generator().manual_seed(7)
    shape = (BATCH, CANDIDATES, 1, HEIGHT, WIDTH)
    return torch.randint(0, 2, shape, generator=generator, dtype=torch.uint8) * 255


def test_probability_for_each_step_from_raw_sensors_with_an_empty_cloud_among_them() -> None:
    probability = small_net(horizon=7)(*raw_inputs())
    assert probability.shape == (BATCH, 7)
    assert probability.dtype == torch.float32
    assert bool(((probability > 0.0) & (probability < 1.0)).all())


def test_forward_is_one_candidate_and_many_candidates_are_many_forwards() -> None:
    net = small_net().eval()
    image, points, count, velocity, trajectory, reliability = raw_inputs()
    f_sensors = net.encode_sensors(image, points, count, velocity)
    assert f_sensors.shape == (BATCH, 100)
    alone = net.score_candidates(f_sensors, trajectory.unsqueeze(1), reliability)
    assert torch.equal(alone.squeeze(1), net(image, points, count, velocity, trajectory, reliability))
    candidates = many_trajectories()
    together = net.score_candidates(f_sensors, candidates, reliability)
    for k in range(CANDIDATES):
        one = net(image, points, count, velocity, candidates[:, k], reliability)
        torch.testing.assert_close(together[:, k], one, atol=1e-6, rtol=1e-5)


@pytest.mark.parametrize(
    "options",
    [{}, {"attention_heads": 2, "self_loop_weight": 1.0}, {"attention_uses_edges": False, "reliability_aware": False}],
)
def test_scripted_saved_and_frozen_equal_eager(options: dict[str, Any], tmp_path: Path) -> None:
    net = small_net(**options).eval()
    inputs, candidates = raw_inputs(), many_trajectories()
    jit.script(net).save(tmp_path / "net.ts")
    loaded = jit.load(tmp_path / "net.ts")
    frozen = jit.freeze(loaded, preserved_attrs=["encode_sensors", "score_candidates"])
    expected = net(*inputs)
    expected_candidates = net.score_candidates(net.encode_sensors(*inputs[:4]), candidates, inputs[5])
    for scripted in (loaded, frozen):
        torch.testing.assert_close(scripted(*inputs), expected, atol=1e-5, rtol=1e-5)
        scores = scripted.score_candidates(scripted.encode_sensors(*inputs[:4]), candidates, inputs[5])
        torch.testing.assert_close(scores, expected_candidates, atol=1e-5, rtol=1e-5)


def test_gradient_reaches_every_encoder_and_the_graph() -> None:
    net = small_net()
    torch.autograd.backward(net(*raw_inputs()).sum())
    reached = {
        name.split(".")[0]
        for name, parameter in net.named_parameters()
        if parameter.grad is not None and float(parameter.grad.abs().sum()) > 0.0
    }
    assert reached == {"image_net", "point_net", "velocity_net", "trajectory_net", "agnn"}


@pytest.mark.parametrize("position", range(6))
def test_every_input_matters(position: int) -> None:
    net = small_net().eval()
    inputs, other = list(raw_inputs()), raw_inputs(seed=2)
    expected = net(*inputs)
    inputs[position] = torch.tensor([20, 5, 40]) if position == 2 else other[position]
    assert not torch.equal(net(*inputs), expected)


def test_same_seed_same_network_same_step() -> None:
    def step() -> dict[str, Tensor]:
        net = small_net(seed=3)
        optimizer = torch.optim.Adam(net.parameters(), lr=0.002)
        torch.autograd.backward(net(*raw_inputs()).sum())
        optimizer.step()
        return net.state_dict()

    first, second = step(), step()
    for name, tensor in first.items():
        assert torch.equal(second[name], tensor), name
    other = small_net(seed=4).state_dict()
    assert not torch.equal(other["agnn.out.weight"], first["agnn.out.weight"])


def test_without_reliability_awareness_every_pair_is_fully_trusted() -> None:
    net = small_net(reliability_aware=False).eval()
    *sensors, reliability = raw_inputs()
    expected = net(*sensors, reliability)
    assert torch.equal(net(*sensors, torch.zeros_like(reliability)), expected)
    aware = small_net(reliability_aware=True).eval()
    torch.testing.assert_close(aware(*sensors, torch.ones_like(reliability)), expected, atol=1e-6, rtol=1e-5)
    assert not torch.allclose(aware(*sensors, reliability), expected, atol=1e-6)


def test_bfloat16_and_channels_last_stay_near_float32() -> None:
    net = small_net().eval()
    inputs = raw_inputs()
    expected = net(*inputs)
    net.to(memory_format=torch.channels_last)  # type: ignore[call-overload] # missing in the stubs
    torch.testing.assert_close(net(*inputs), expected, atol=1e-5, rtol=1e-4)
    with torch.autocast("cpu", dtype=torch.bfloat16):
        probability = net(*inputs)
        f_sensors = net.encode_sensors(*inputs[:4])
    assert probability.dtype == f_sensors.dtype == torch.float32
    torch.testing.assert_close(probability, expected, atol=0.05, rtol=0.0)


def test_bfloat16_leaves_the_graph_and_its_network_in_float32() -> None:
    net = small_net().eval()
    *_, trajectory, reliability = raw_inputs()
    f_sensors = torch.rand(BATCH, 100, generator=torch.Generator().manual_seed(0))
    net.trajectory_net.forward = lambda trajectory: torch.full((len(trajectory), 20), 0.5)  # type: ignore[method-assign] # only what follows it
    expected = net.score_candidates(f_sensors, trajectory.unsqueeze(1), reliability)
    with torch.autocast("cpu", dtype=torch.bfloat16):
        assert torch.equal(net.score_candidates(f_sensors, trajectory.unsqueeze(1), reliability), expected)


def test_sizes_are_free() -> None:
    graph = FeatureGraphConfig(image=6, point=5, velocity=4, trajectory=3, edge_decay=8.0)
    net = small_net(graph=graph, history=20, point_feature_transform=True, point_widths=[8, 8, 16])
    image, points, count, velocity, trajectory, reliability = raw_inputs()
    assert net(image, points, count, velocity[:, -20:], trajectory, reliability).shape == (BATCH, 10)


def test_a_few_steps_take_most_of_the_error_away() -> None:
    torch.manual_seed(0)
    net = Graspe(GraspeConfig(image_height=48, image_width=48, dropout=0.0))
    inputs, target, known = _learnable_samples(12)
    optimizer = torch.optim.Adam(net.parameters(), lr=1e-3)
    losses = []
    for _ in range(10):
        optimizer.zero_grad()
        loss = masked_mse(net(*inputs), target, known)
        torch.autograd.backward(loss)
        optimizer.step()
        losses.append(loss.item())
    assert losses[-1] < 0.5 * losses[0]


@pytest.mark.slow
def test_overfits_32_samples() -> None:
    """The paper's network at its full width, on small images: it learns 32 samples by heart, in evaluation mode too."""
    torch.manual_seed(0)
    net = Graspe(GraspeConfig(image_height=48, image_width=48, dropout=0.1))
    inputs, target, known = _learnable_samples()
    optimizer = torch.optim.Adam(net.parameters(), lr=1e-3, weight_decay=0.00025)
    for _ in range(150):
        net.train()
        optimizer.zero_grad()
        loss = masked_mse(net(*inputs), target, known)
        torch.autograd.backward(loss)
        optimizer.step()
        if loss.item() < 0.007:
            for group in optimizer.param_groups:
                group["lr"] = 1e-4  # so that the running statistics catch up
            net.eval()
            with torch.no_grad():
                judged = masked_mse(net(*inputs), target, known).item()
            if judged < 0.009:
                break
    assert loss.item() < 0.01
    assert judged < 0.01


def _learnable_samples(number: int = 32) -> tuple[Inputs, Tensor, Tensor]:
    """Noise in every modality, on it the number of steps that succeed; a fifth of the labels unknown (and wrong)."""
    generator = torch.Generator().manual_seed(1)
    good = torch.randint(0, 11, (number, 1), generator=generator)
    share = good / 10.0
    image = torch.rand(number, 3, 48, 48, generator=generator) * 55.0 + share.view(number, 1, 1, 1) * 200.0
    points = torch.randn(number, 64, 3, generator=generator)
    points[:, :, 0] += share * 10.0
    count = torch.randint(32, 65, (number,), generator=generator)
    velocity = torch.rand(number, 50, 2, generator=generator) * 0.2 + share.view(number, 1, 1)
    trajectory = (torch.rand(number, 1, 48, 48, generator=generator) < share.view(number, 1, 1, 1)).to(
        torch.uint8
    ) * 255
    reliability = torch.rand(number, 2, generator=generator)
    success = torch.arange(10) < good
    known = torch.rand(number, 10, generator=generator) < 0.8
    target = torch.where(known, success, ~success).float()
    return (image.to(torch.uint8), points, count, velocity, trajectory, reliability), target, known


class TestPretrainedImageWeights:
    def test_come_from_the_file_and_only_when_asked(self, tmp_path: Path) -> None:
        torch.manual_seed(5)
        donor = resnet18(weights=None).state_dict()
        torch.save(donor, tmp_path / "resnet18.pt")
        net = small_net(pretrained_image_weights=str(tmp_path / "resnet18.pt"))
        assert not torch.equal(net.image_net.backbone.conv1.weight, donor["conv1.weight"])
        net.load_pretrained_image_weights()
        assert torch.equal(net.image_net.backbone.conv1.weight, donor["conv1.weight"])

    def test_none_configured_leaves_the_network_alone(self) -> None:
        net = small_net()
        before = net.image_net.backbone.conv1.weight.clone()
        net.load_pretrained_image_weights()
        assert torch.equal(net.image_net.backbone.conv1.weight, before)

    def test_a_missing_file_is_reported_with_the_cure(self, tmp_path: Path) -> None:
        net = small_net(pretrained_image_weights=str(tmp_path / "absent.pt"))
        with pytest.raises(TrainError, match="no such file") as caught:
            net.load_pretrained_image_weights()
        assert caught.value.where == str(tmp_path / "absent.pt")
        assert caught.value.cure is not None
        assert "downloaded" in caught.value.cure

    @pytest.mark.parametrize("write", ["another network", "pickle with code", "list", "text", "nothing"])
    def test_any_other_content_is_one_clear_error_and_never_executed(self, write: str, tmp_path: Path) -> None:
        path = tmp_path / "weights.pt"
        writers: dict[str, Callable[[], object]] = {
            "another network": lambda: torch.save(torch.nn.Linear(2, 2).state_dict(), path),
            "pickle with code": lambda: torch.save(_Touch(tmp_path / "executed"), path),
            "list": lambda: torch.save([1, 2], path),
            "text": lambda: path.write_text("no weights here"),
            "nothing": path.touch,
        }
        writers[write]()
        net = small_net(pretrained_image_weights=str(path))
        with pytest.raises(TrainError, match="not a ResNet18 state dict") as caught:
            net.load_pretrained_image_weights()
        assert caught.value.where == str(path)
        assert not (tmp_path / "executed").exists()


class _Touch:
    """Creates a file when unpickled by a reader that executes what it reads."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def __reduce__(self) -> tuple[Callable[[Path], None], tuple[Path]]:
        return Path.touch, (self.path,)
