"""``navtool demo``."""

import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import typer


def demo(
    out: Path = typer.Option(Path("demo-output"), "--out", help="Folder for everything; must be empty or absent."),
    seed: int = typer.Option(0, "--seed", min=0, help="Decides the recordings and the training."),
    episodes: int = typer.Option(6, "--episodes", min=3, help="Recordings to write."),
    seconds: float = typer.Option(12.0, "--seconds", min=10.0, help="Length of each recording."),
    epochs: int = typer.Option(2, "--epochs", min=1, help="Epochs to train."),
) -> None:
    """Run the whole chain on generated recordings.

    Record, ingest, label, check, train, evaluate, export, verify, in a few minutes. The recordings come from a small
    analytic world; everything after them is what real recordings go through.
    """
    from navtool.cli.compose import UsageError
    from navtool.cli.console import console

    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise UsageError("is not an empty folder", where=out, cure="choose another with --out, or remove it")
    stages = _Stages()
    _data_set(stages, out, seed, episodes, seconds)
    verified = _model(stages, out, seed, epochs)
    console().rule("Done", align="left")
    stages.print_table()
    if not verified:
        raise typer.Exit(1)


class _Stages:
    """Announces each stage and remembers how long it took and where its output lies."""

    def __init__(self) -> None:
        self._done: list[tuple[str, str, float, Path]] = []

    @contextmanager
    def stage(self, name: str, does: str, where: Path) -> Iterator[Path]:
        from navtool.cli.console import console

        console().rule(f"{len(self._done) + 1}. {name}: {does}", align="left")
        started = time.monotonic()
        yield where
        self._done.append((name, does, time.monotonic() - started, where))

    def print_table(self) -> None:
        from navtool.cli.console import print_table

        total_s = sum(seconds for _, _, seconds, _ in self._done)
        rows = [(name, does, round(seconds, 1), where) for name, does, seconds, where in self._done]
        print_table(f"The whole chain in {total_s:.0f} s", ("stage", "what", "seconds", "output"), rows)


def _data_set(stages: _Stages, out: Path, seed: int, episodes: int, seconds: float) -> None:
    from navtool.cli.check import check
    from navtool.cli.compose import compose
    from navtool.cli.console import console
    from navtool.cli.ingest import print_ingest
    from navtool.cli.label import print_labels
    from navtool.cli.progress import IngestProgress, counted
    from navtool.cli.robots import ingest_job
    from navtool.datasets.ingest.ingest import ingest
    from navtool.datasets.labels.apply import label_dataset
    from navtool.datasets.labels.config import LabelConfig
    from navtool.sim.demo import write_demo_recordings

    with stages.stage("record", f"a careless robot drives {episodes} times", out / "recordings") as recordings:
        with counted("recordings", episodes) as advance:
            paths = write_demo_recordings(recordings, seed, episodes, seconds, advance)
        console().print("\n".join(f"{path} ({path.stat().st_size / 1e6:.1f} MB)" for path in paths), markup=False)
    with stages.stage("ingest", "recordings to a LeRobotDataset v3", out / "dataset") as dataset:
        job = ingest_job(None, ["place='{parent}'"])
        with IngestProgress() as progress:
            print_ingest(ingest(paths, dataset, job.robot, job.config(), progress=progress))
    with stages.stage("label", "collisions, standstills and interventions", dataset):
        print_labels(label_dataset(dataset, compose("label", [], LabelConfig)), dataset)
    with stages.stage("check", "every row, frame and footer", dataset):
        check(dataset, as_json=False)


def _model(stages: _Stages, out: Path, seed: int, epochs: int) -> bool:
    from navtool.cli.compose import compose, quoted
    from navtool.cli.evaluate import print_evaluation
    from navtool.cli.train import print_run
    from navtool.cli.verify import print_verification
    from navtool.configs.train_job import TrainJob
    from navtool.export.evaluate import evaluate_source
    from navtool.export.torchscript import export_run
    from navtool.export.verify import verify
    from navtool.train.run import train

    dataset = out / "dataset"
    with stages.stage("train", f"GrASPE, {epochs} epochs", out / "run") as run:
        settings = ["experiment=demo", f"seed={seed}", f"trainer.epochs={epochs}", f"dataset={quoted(dataset)}"]
        print_run(train(compose("train", settings, TrainJob).config(), dataset, run, progress=True))
    with stages.stage("evaluate", "on a place that training never saw", run / "evaluation.json") as report:
        print_evaluation(evaluate_source(run, dataset, "test", report))
    with stages.stage("export", "TorchScript with its manifest", out / "artefact") as artefact:
        export_run(run, artefact)
    with stages.stage("verify", "hashes, contract, parity, latency", artefact):
        verification = verify(artefact)
        print_verification(verification)
    return verification.passed
