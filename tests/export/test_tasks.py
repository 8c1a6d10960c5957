"""A classifier, a regressor and a segmenter, each with data, loss and metrics of its own, from training to artefact."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple, Self

import numpy as np
import pytest
import torch
from numpy.typing import NDArray
from torch import Tensor, nn
from torch.nn import functional

from navtool.datasets.store.reader import Episode
from navtool.export.evaluate import evaluate_source
from navtool.export.manifest import read_manifest
from navtool.export.torchscript import export_run
from navtool.export.verify import verify
from navtool.train.checkpoint import load_run
from navtool.train.config import Device, OptimizerConfig, TrainConfig, TrainerConfig
from navtool.train.contract import Contract, TensorSpec
from navtool.train.evaluate import evaluate_run
from navtool.train.judgement import Judge, Judgement, Table
from navtool.train.layers.checked_input import check_input
from navtool.train.model_config import ModelConfig
from navtool.train.model_kind import AnyKind, ModelKind
from navtool.train.models import MODELS
from navtool.train.run import train
from navtool.train.run_folder import RunFolder
from navtool.train.samples import SampleReport, Samples
from navtool.train.splits import SplitConfig
from navtool.train.task import Loss, Task

PLACES = ("lawn", "park", "wood")
SIZE = (6, 8)
IMAGE = TensorSpec("image", ("batch", 3, "height", "width"), "uint8", "1", (0, 255), "RGB")


class ImageFolder:
    """Pictures in a folder a place: no data set of recordings, no poses, no labels."""

    def __init__(self, images: dict[str, NDArray[np.uint8]], root: Path | None = None) -> None:
        self.root = root
        self.images = np.concatenate(list(images.values()))
        stops = np.cumsum([len(part) for part in images.values()]).tolist()
        starts = [0, *stops[:-1]]
        self.episodes = tuple(
            Episode(index, starts[index], stops[index], place, place) for index, place in enumerate(images)
        )

    @classmethod
    def read(cls, folder: Path) -> Self:
        return cls({path.stem: np.load(path) for path in sorted(folder.glob("*.npy"))}, folder)

    @classmethod
    def drawn(cls, seed: int = 0) -> Self:
        """Dark ground below a horizon that lies elsewhere in each picture, brighter sky above it."""
        rng = np.random.default_rng(seed)
        rows = np.arange(SIZE[0])[:, None, None]
        horizon = rng.integers(1, SIZE[0], (len(PLACES), 12, 1, 1, 1))
        noise = rng.integers(0, 40, (len(PLACES), 12, *SIZE, 3))
        pictures = (np.where(rows < horizon, 180, 30) + noise).astype(np.uint8)
        return cls(dict(zip(PLACES, pictures, strict=True)))

    def lineage(self) -> dict[str, object]:
        return {"pictures": len(self.images)}


class Labelled(NamedTuple):
    image: Tensor
    target: Tensor


class Pictures(Samples[Labelled]):
    """Every picture, with what a function says is true of it."""

    def __init__(
        self, source: ImageFolder, episodes: Sequence[int], truth: Callable[[NDArray[np.uint8]], object]
    ) -> None:
        spans = [source.episodes[index] for index in episodes]
        self.row = np.concatenate([np.arange(span.start, span.stop) for span in spans])
        self.episode = np.concatenate([np.full(span.stop - span.start, span.index) for span in spans])
        self.report = SampleReport(len(self.row), len(self.row), {})
        self._images, self._truth = source.images, truth

    def __getitem__(self, index: int) -> Labelled:
        image = self._images[self.row[index]]
        return Labelled(torch.from_numpy(image).permute(2, 0, 1), torch.as_tensor(self._truth(image)))


@dataclass(kw_only=True, slots=True)
class RegressorConfig(ModelConfig):
    """Nothing to set."""


@dataclass(kw_only=True, slots=True)
class ClassifierConfig(ModelConfig):
    """Nothing to set."""


@dataclass(kw_only=True, slots=True)
class SegmenterConfig(ModelConfig):
    """Nothing to set."""


class Regressor(nn.Module):
    """One number a picture, of any size."""

    def __init__(self, _config: RegressorConfig) -> None:
        super().__init__()
        self.layer = nn.Linear(3, 1)

    def forward(self, image: Tensor) -> Tensor:
        check_input(image, "image", "uint8", [-1, 3, -1, -1])
        answer: Tensor = self.layer(image.float().mean(dim=(2, 3)) / 255.0)
        return answer


class Classifier(nn.Module):
    """The log-probabilities of two classes of pictures."""

    def __init__(self, _config: ClassifierConfig) -> None:
        super().__init__()
        self.layer = nn.Linear(3, 2)

    def forward(self, image: Tensor) -> Tensor:
        check_input(image, "image", "uint8", [-1, 3, -1, -1])
        return functional.log_softmax(self.layer(image.float().mean(dim=(2, 3)) / 255.0), dim=1)


class Segmenter(nn.Module):
    """Scores of each class at each pixel."""

    def __init__(self, _config: SegmenterConfig) -> None:
        super().__init__()
        self.layer = nn.Conv2d(3, 2, 1)

    def forward(self, image: Tensor) -> Tensor:
        check_input(image, "image", "uint8", [-1, 3, -1, -1])
        answer: Tensor = self.layer(image.float() / 255.0)
        return answer


class ErrorJudge:
    """Root mean square of what a regressor is wrong by."""

    def __init__(self, _config: TrainConfig) -> None:
        self.squares: list[float] = []

    def add(self, batch: Labelled, output: Tensor) -> None:
        self.squares += (output[:, 0].cpu() - batch.target.cpu()).square().tolist()

    def result(self) -> Judgement:
        mse = float(np.mean(self.squares))
        rmse = math.sqrt(mse)
        return Judgement(mse, {"rmse": rmse}, {"rmse": rmse}, Table("Regression", ("all",), [("rmse", rmse)]))


class ConfusionJudge:
    """Counts what is taken for what, so that it keeps no predictions; the class axis is the second."""

    def __init__(self, _config: TrainConfig) -> None:
        self.table = torch.zeros(2, 2, dtype=torch.int64)
        self.loss = 0.0

    def add(self, batch: Labelled, output: Tensor) -> None:
        self.loss += float(functional.cross_entropy(output, batch.target, reduction="sum"))
        self.table += torch.bincount((2 * batch.target + output.argmax(dim=1)).flatten().cpu(), minlength=4).view(2, 2)

    def result(self) -> Judgement:
        union = self.table.sum(0) + self.table.sum(1) - self.table.diag()
        iou = (self.table.diag() / union.clamp(min=1)).tolist()
        accuracy = float(self.table.diag().sum() / self.table.sum())
        figures = {"accuracy": accuracy, "iou": iou}
        table = Table("Classes", ("ground", "sky"), [("iou", *iou)])
        return Judgement(self.loss / int(self.table.sum()), figures, {"accuracy": accuracy}, table)


def cross_entropy(output: Tensor, batch: Labelled) -> Loss:
    return Loss(functional.cross_entropy(output, batch.target), batch.target.numel())


def squared_error(output: Tensor, batch: Labelled) -> Loss:
    return Loss(functional.mse_loss(output[:, 0], batch.target), len(batch.target))


def brightness(image: NDArray[np.uint8]) -> np.float32:
    return np.float32(image.mean() / 255.0)


def much_sky(image: NDArray[np.uint8]) -> int:
    return int(image.mean() > 125.0)


def sky(image: NDArray[np.uint8]) -> NDArray[np.int64]:
    return np.asarray(image.mean(axis=2) > 125.0, dtype=np.int64)


def toy(
    config: type[ModelConfig],
    build: Callable[[Any], nn.Module],
    output: TensorSpec,
    truth: Callable[[NDArray[np.uint8]], object],
    loss: Callable[[Tensor, Labelled], Loss],
    judge: Callable[[TrainConfig], Judge[Labelled, Tensor]],
) -> AnyKind:
    """A row of the table for pictures."""
    task = Task(
        open=ImageFolder.read,
        samples=lambda source, episodes, _config: Pictures(source, episodes, truth),
        loss=loss,
        judge=judge,
    )
    return ModelKind(
        task=task,
        config=config,
        build=build,
        inputs=lambda batch: (batch.image,),
        stand_in=lambda _config: ImageFolder.drawn(),
        contract=lambda _config: Contract((IMAGE,), (output,)),
        onboard=lambda network, _config: network,
    )


NUMBER = TensorSpec("brightness", ("batch", 1), "float32", "1", None, "mean of the picture")
CLASS = TensorSpec("class", ("batch", 2), "float32", "1", (-1e4, 0), "log-probability of ground, sky")
PIXELS = TensorSpec("score", ("batch", 2, "height", "width"), "float32", "1", None, "ground, sky")
KINDS = {
    "regressor": toy(RegressorConfig, Regressor, NUMBER, brightness, squared_error, ErrorJudge),
    "classifier": toy(ClassifierConfig, Classifier, CLASS, much_sky, cross_entropy, ConfusionJudge),
    "segmenter": toy(SegmenterConfig, Segmenter, PIXELS, sky, cross_entropy, ConfusionJudge),
}


@pytest.fixture(params=sorted(KINDS))
def name(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    """The name of a toy that stands in the table."""
    monkeypatch.setitem(MODELS, request.param, KINDS[request.param])
    return str(request.param)


@pytest.fixture
def pictures(tmp_path: Path) -> Path:
    folder = tmp_path / "pictures"
    folder.mkdir()
    drawn = ImageFolder.drawn(1)
    for episode in drawn.episodes:
        np.save(folder / f"{episode.place}.npy", drawn.images[episode.start : episode.stop])
    return folder


def test_each_kind_of_task_goes_from_pictures_to_a_verified_artefact(name: str, pictures: Path, tmp_path: Path) -> None:
    config = TrainConfig(
        model=KINDS[name].config(),
        trainer=TrainerConfig(epochs=12, batch_size=4, device=Device.cpu),
        optimizer=OptimizerConfig(learning_rate=0.1, weight_decay=0.0),
        split=SplitConfig(train_places=["wood"], val_places=["park"], test_places=["lawn"]),
    )
    first = train(replace(config, trainer=replace(config.trainer, epochs=1)), pictures, tmp_path / "short")
    result = train(config, pictures, tmp_path / "run")
    assert result.best_val_loss < 0.8 * first.best_val_loss, "it learns"
    assert RunFolder(result.run).read_config() == config

    artefact = export_run(result.run, tmp_path / "artefact")
    manifest = read_manifest(artefact)
    assert (manifest.kind, manifest.golden_source) == (name, "data set rows [0, 6, 11]")
    report = verify(artefact, 1)
    assert report.passed, [check for check in report.checks if not check.ok]

    of_run, of_artefact = evaluate_run(result.run), evaluate_source(artefact, pictures)
    assert (of_run.kind, of_artefact.kind, of_run.samples) == ("run", "artefact", 12)
    assert of_run.loss == pytest.approx(of_artefact.loss, abs=1e-6)
    for (metric, *ran), (_, *exported) in zip(of_run.table.rows, of_artefact.table.rows, strict=True):
        assert ran == pytest.approx(exported, abs=1e-6), metric
    stored = RunFolder(result.run).read_metrics()
    assert stored is not None
    assert stored["splits"]["test"]["metrics"] == of_run.to_json()["metrics"]


def test_the_figures_are_those_of_a_naive_reading(name: str, pictures: Path, tmp_path: Path) -> None:
    config = TrainConfig(
        model=KINDS[name].config(),
        trainer=TrainerConfig(epochs=1, batch_size=5, device=Device.cpu),
        split=SplitConfig(train_places=["wood"], val_places=["park"], test_places=["lawn"]),
    )
    run = train(config, pictures, tmp_path / "run").run
    report = evaluate_run(run)
    lawn = np.load(pictures / "lawn.npy")
    with torch.inference_mode():
        output = load_run(run).model(torch.from_numpy(lawn).permute(0, 3, 1, 2))
    if name == "regressor":
        mse = float(np.mean([(float(output[i, 0]) - brightness(picture)) ** 2 for i, picture in enumerate(lawn)]))
        assert report.loss == pytest.approx(mse, rel=1e-5)
        assert report.metrics == {"rmse": pytest.approx(math.sqrt(mse), rel=1e-5)}
        return
    truth = np.stack([sky(picture) if name == "segmenter" else np.asarray(much_sky(picture)) for picture in lawn])
    chance = output.softmax(dim=1).numpy()
    assert report.loss == pytest.approx(float(-np.log(np.where(truth, chance[:, 1], chance[:, 0])).mean()), rel=1e-5)
    said = chance[:, 1] > chance[:, 0]
    iou = [(truth == k)[said == k].sum() / ((truth == k) | (said == k)).sum() for k in (0, 1)]
    assert report.metrics == {"accuracy": pytest.approx((said == truth).mean()), "iou": pytest.approx(iou)}
