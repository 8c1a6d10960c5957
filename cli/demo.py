"""``navtool demo``."""

import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import typer

if TYPE_CHECKING:
    from navtool.cli.demo_report import DemoReport
    from navtool.datasets.labels.report import LabelReport

_FPS = 5
"""Ten steps ahead are then two seconds: the robot's way reaches into the picture, beyond its own nose."""


def demo(
    out: Path = typer.Option(Path("demo-output"), "--out", help="Folder for everything; must be empty or absent."),
    seed: int = typer.Option(0, "--seed", min=0, help="Decides the recordings and the training."),
    episodes: int = typer.Option(6, "--episodes", min=3, help="Recordings to write."),
    seconds: float = typer.Option(12.0, "--seconds", min=10.0, help="Length of each recording."),
    epochs: int = typer.Option(2, "--epochs", min=1, help="Epochs to train."),
) -> None:
    """Run the whole chain on simulated recordings.

    Record, ingest, label, check, train, evaluate, export, verify, in a few minutes; OUT/report.html shows it with
    pictures. The recordings come from simulated places; everything after them is what real recordings go through.
    """
    from navtool.base.files import write_bytes
    from navtool.cli.compose import UsageError
    from navtool.cli.console import console

    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise UsageError("is not an empty folder", where=out, cure="choose another with --out, or remove it")
    stages = Stages()
    recorded = _record(stages, out, seed, episodes, seconds)
    labels = _data_set(stages, out, recorded)
    report = _model(stages, out, seed, epochs, labels, recorded)
    write_bytes(out / "report.html", report.page().encode())
    console().rule("Done", align="left")
    stages.print_table()
    console().print(f"report with pictures: {out / 'report.html'}", markup=False)
    if not report.verification.passed:
        raise typer.Exit(1)


class Recorded(NamedTuple):
    """The recordings of a demo."""

    paths: list[Path]
    sheets: dict[str, bytes]
    """A contact sheet of the first one in each place, by its name."""


class Stages:
    """Announces each stage and remembers how long it took and where its output lies."""

    def __init__(self) -> None:
        self.done: list[tuple[str, str, float, Path]] = []

    @contextmanager
    def stage(self, name: str, does: str, where: Path) -> Iterator[Path]:
        """A stage begins; its path is given back, and the clock stops with the block."""
        from navtool.cli.console import console

        console().rule(f"{len(self.done) + 1}. {name}: {does}", align="left")
        started = time.monotonic()
        yield where
        self.done.append((name, does, time.monotonic() - started, where))

    def print_table(self) -> None:
        """Print what has been done."""
        from navtool.cli.console import print_table

        total_s = sum(seconds for _, _, seconds, _ in self.done)
        rows = [(name, does, round(seconds, 1), where) for name, does, seconds, where in self.done]
        print_table(f"The whole chain in {total_s:.0f} s", ("stage", "what", "seconds", "output"), rows)


def _record(stages: Stages, out: Path, seed: int, episodes: int, seconds: float) -> Recorded:
    from navtool.cli.simulate import print_simulation, run_simulation, simulation_config
    from navtool.sim.record.preview import contact_sheet_png

    settings = ["scenario=demo", f"drive.duration_s={seconds}", "drive.careful=0", "drive.mischief=0.7"]
    with stages.stage("record", "a careless robot drives about simulated places", out / "recordings") as folder:
        config = simulation_config(settings)
        simulation = run_simulation(config, folder, episodes, seed, workers=2)
        sheets = {
            episode.plan.path: contact_sheet_png(config, seed, episode.plan.number)
            for episode in simulation.episodes[:: config.episodes_per_place]
        }
        print_simulation(simulation)
    return Recorded([folder / episode.plan.path for episode in simulation.episodes], sheets)


def _data_set(stages: Stages, out: Path, recorded: Recorded) -> "LabelReport":
    from navtool.cli.check import check
    from navtool.cli.compose import compose
    from navtool.cli.ingest import print_ingest
    from navtool.cli.label import print_labels
    from navtool.cli.progress import WorkProgress
    from navtool.cli.robots import ingest_job
    from navtool.datasets.ingest.ingest import ingest
    from navtool.datasets.labels.apply import label_dataset
    from navtool.datasets.labels.config import LabelConfig

    with stages.stage("ingest", "recordings to a LeRobotDataset v3", out / "dataset") as dataset:
        job = ingest_job(None, ["place='{parent}'", f"fps={_FPS}"])
        with WorkProgress("recordings") as progress:
            print_ingest(ingest(recorded.paths, dataset, job.robot, job.config(), workers=2, progress=progress))
    with stages.stage("label", "collisions, standstills and interventions", dataset):
        with WorkProgress("episodes") as progress:
            labels = label_dataset(dataset, compose("label", [], LabelConfig), progress=progress)
        print_labels(labels, dataset)
    with stages.stage("check", "every row, frame and footer", dataset):
        check(dataset, splits=None, as_json=False)
    return labels


def _model(
    stages: Stages, out: Path, seed: int, epochs: int, labels: "LabelReport", recorded: Recorded
) -> "DemoReport":
    from navtool.cli.compose import compose, quoted
    from navtool.cli.demo_report import DemoReport
    from navtool.cli.evaluate import print_evaluation
    from navtool.cli.progress import WorkProgress
    from navtool.cli.train import print_run
    from navtool.cli.verify import print_verification
    from navtool.configs.train_job import TrainJob
    from navtool.datasets.store.reader import NavDataset
    from navtool.export.evaluate import evaluate_source
    from navtool.export.torchscript import export_run
    from navtool.export.verify import verify
    from navtool.train.prediction_picture import prediction_picture
    from navtool.train.run import train

    dataset = out / "dataset"
    with stages.stage("train", f"GrASPE, {epochs} epochs", out / "run") as run:
        settings = ["experiment=demo", f"seed={seed}", f"trainer.epochs={epochs}", f"dataset={quoted(dataset)}"]
        with WorkProgress("epochs") as progress:
            print_run(train(compose("train", settings, TrainJob).config(), dataset, run, progress=progress))
    with stages.stage("evaluate", "on a place that training never saw", run / "evaluation.json") as written:
        evaluation = evaluate_source(run, dataset, "test", written)
        print_evaluation(evaluation)
    with stages.stage("export", "TorchScript with its manifest", out / "artefact") as artefact:
        export_run(run, artefact)
    with stages.stage("verify", "hashes, contract, parity, latency", artefact):
        verification = verify(artefact)
        print_verification(verification)
    opened = NavDataset(dataset)
    first = opened.episodes[0]
    return DemoReport(
        stages=stages.done,
        sheets=recorded.sheets,
        sync={first.source: (opened.layout.episode(first.index) / "sync.svg").read_text()},
        labels=labels,
        predictions=prediction_picture(run, dataset),
        evaluation=evaluation,
        verification=verification,
    )
