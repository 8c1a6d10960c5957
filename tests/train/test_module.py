"""The training step and the validation figures."""

import pytest
import torch
from torch import Tensor, nn

from navtool.base.setting_error import SettingError
from navtool.train.config import Device, OptimizerConfig, Precision, TrainConfig, TrainerConfig
from navtool.train.datamodule import sample_loader
from navtool.train.graspe.config import GraspeConfig
from navtool.train.module import NetworkModule
from navtool.train.predict import predict
from navtool.train.splits import GroupBy, Split
from navtool.train.success.figure import prediction_figure
from navtool.train.success.loss import masked_mse
from navtool.train.success.predictions import PredictionLog, Predictions
from navtool.train.success.samples import SampleDataset
from navtool.train.success.windows import DataConfig, MissingModality, plan_windows
from navtool.train.synthetic import SyntheticConfig, SyntheticSource


class Bright(nn.Module):
    """One weight, so that its gradient can be worked out by hand."""

    def __init__(self) -> None:
        super().__init__()
        self.weight = nn.Parameter(torch.tensor(0.5))

    def forward(
        self, image: Tensor, points: Tensor, count: Tensor, velocity: Tensor, trajectory: Tensor, reliability: Tensor
    ) -> Tensor:
        del points, count, velocity, trajectory, reliability
        brightness = image.float().mean(dim=(1, 2, 3)) / 255.0
        return (self.weight * brightness)[:, None].expand(-1, 10)


def dataset(world: SyntheticConfig) -> SampleDataset:
    source = SyntheticSource(world)
    return SampleDataset(source, plan_windows(source, [0, 1, 2], DataConfig()), DataConfig())


def predictions(world: SyntheticConfig, batch_size: int) -> Predictions:
    model, log = Bright().eval(), PredictionLog()
    for batch in sample_loader(dataset(world), batch_size, workers=0):
        log.add(batch, predict(model, batch.inputs(), torch.device("cpu")))
    return log.predictions()


def test_predictions_do_not_depend_on_the_batches(small_world: SyntheticConfig) -> None:
    whole, parts = predictions(small_world, 36), predictions(small_world, 5)
    assert whole.row.tolist() == parts.row.tolist() == list(range(36))
    assert whole.loss() == pytest.approx(parts.loss(), abs=1e-7)
    assert (whole.probability == parts.probability).all()


def test_the_loss_is_the_mean_over_known_steps(small_world: SyntheticConfig) -> None:
    got = predictions(small_world, 8)
    error = (got.probability - got.target)[got.known] ** 2
    assert got.loss() == pytest.approx(float(error.mean()), abs=1e-6)


def test_a_step_follows_the_gradient_of_the_masked_loss(
    small_world: SyntheticConfig, small_config: TrainConfig
) -> None:
    batch = next(iter(sample_loader(dataset(small_world), 8, workers=0)))
    model = Bright()
    loss = masked_mse(NetworkModule(model, small_config).model(*batch.inputs()), batch.target, batch.known)
    (gradient,) = torch.autograd.grad(loss, [model.weight])
    brightness = batch.image.float().mean(dim=(1, 2, 3))[:, None] / 255.0
    by_hand = (2 * (0.5 * brightness - batch.target) * brightness)[batch.known].mean()
    assert float(gradient) == pytest.approx(float(by_hand), abs=1e-6)


def test_the_optimiser_is_the_papers() -> None:
    optimizer = NetworkModule(Bright(), TrainConfig(model=GraspeConfig())).configure_optimizers()
    assert isinstance(optimizer, torch.optim.Adam)
    assert (optimizer.defaults["lr"], optimizer.defaults["weight_decay"]) == (0.002, 0.00025)  # GrASPE, Table IV


def test_the_figure_shows_each_sample(small_world: SyntheticConfig) -> None:
    data = dataset(small_world)
    chosen = [data[0], data[20]]
    probability = predictions(small_world, 36).probability[[0, 20]]
    figure = prediction_figure(chosen, probability, success_threshold=0.56)
    assert len(figure.axes) == 4
    line = figure.axes[2].get_lines()[1]
    assert line.get_ydata() == pytest.approx(probability[0])
    known = figure.axes[3].get_lines()[2]
    assert len(known.get_ydata()) == int(chosen[1].known.sum())  # type: ignore[arg-type]  # stubs allow scalars


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: OptimizerConfig(learning_rate=0.0), "learning_rate"),
        (lambda: OptimizerConfig(weight_decay=-1.0), "weight_decay"),
        (lambda: TrainerConfig(epochs=0, batch_size=1), r"epochs: 0 .*batch_size: 1"),
        (lambda: TrainerConfig(gradient_clip=0.0), "gradient_clip"),
        (lambda: TrainConfig(model=GraspeConfig(horizon=5)), r"model\.horizon: 5 differs from data\.horizon_steps"),
        (lambda: TrainConfig(model=GraspeConfig(), seed=-1), "seed"),
    ],
)
def test_impossible_settings_are_refused(make: "object", message: str) -> None:
    assert callable(make)
    with pytest.raises(SettingError, match=message):
        make()


def test_enum_members_are_named_as_their_values() -> None:
    for kind in (Device, Precision, MissingModality, GroupBy, Split):
        assert [member.name for member in kind] == [member.value for member in kind]
