"""``navtool train``."""

from pathlib import Path
from typing import TYPE_CHECKING

import typer

if TYPE_CHECKING:
    from omegaconf import DictConfig

    from navtool.train.run import RunResult


def train(
    overrides: list[str] | None = typer.Argument(None, metavar="[KEY=VALUE]...", help="Such as trainer.epochs=5."),
    data: Path | None = typer.Option(None, "--data", help="Folder of the data set (or dataset=FOLDER)."),
    out: Path | None = typer.Option(None, "--out", help="Run folder, or folder of the runs with -m."),
    multirun: bool = typer.Option(False, "--multirun", "-m", help="Run every combination of comma-separated values."),
    cfg: str | None = typer.Option(None, "--cfg", help="Print the configuration (job, hydra or all)."),
    resume: Path | None = typer.Option(None, "--resume", help="Go on with an interrupted run from its last epoch."),
    as_json: bool = typer.Option(False, "--json", help="Print JSON; of a single run."),
) -> None:
    """Train a model on a labelled data set.

    Goes through Hydra, so that its launchers and sweepers plug in. Experiments, as experiment=NAME: cpu (minutes
    without a GPU), demo, graspe_paper, graspe_without_reliability.
    """
    from navtool.cli.arguments import require_there
    from navtool.cli.compose import UsageError, quoted
    from navtool.cli.hydra_job import run_through_hydra

    if resume is not None:
        if overrides or data or out or multirun or cfg:
            raise UsageError("--resume goes on with a run as it was configured", cure="pass --resume RUN alone")
        require_there(resume)
        print_run(resume_run(resume), as_json=as_json)
        return
    if as_json and multirun:
        cure = "read summary.json in the folder of the runs"
        raise UsageError("--json prints one run's report, and --multirun makes several", cure=cure)
    arguments = list(overrides or [])
    if data is not None:
        arguments.append(f"dataset={quoted(data.resolve())}")
    if out is not None:
        arguments.append(f"hydra.{'sweep' if multirun else 'run'}.dir={quoted(out)}")
    if multirun:
        arguments.append("--multirun")
    if cfg is not None:
        arguments += ["--cfg", cfg]
    run_through_hydra(json_job if as_json else train_job, "train", arguments)


def json_job(composed: "DictConfig") -> float:
    """`train_job` with its report for programs."""
    return train_job(composed, as_json=True)


def train_job(composed: "DictConfig", *, as_json: bool = False) -> float:
    """One job: train into Hydra's output folder; the value is what a sweeper minimises (best validation loss)."""
    from hydra.core.hydra_config import HydraConfig
    from omegaconf import OmegaConf

    from navtool.cli.arguments import require_there
    from navtool.cli.compose import UsageError, to_typed, wrong_call
    from navtool.cli.progress import WorkProgress
    from navtool.configs.train_job import TrainJob
    from navtool.train.resume import first_epoch
    from navtool.train.run import train as run
    from navtool.train.run_folder import RunFolder

    if OmegaConf.is_missing(composed, "dataset"):
        raise UsageError("no data set was named", where="train", cure="pass --data FOLDER")
    job = to_typed(composed, TrainJob)
    require_there(Path(job.dataset), *job.model.files())
    out = Path(HydraConfig.get().runtime.output_dir)
    with wrong_call():
        first_epoch(RunFolder(out), job.config(), resume=False)
    with WorkProgress("epochs") as progress:
        result = run(job.config(), Path(job.dataset), out, progress=progress)
    print_run(result, as_json=as_json)
    return result.best_val_loss


def resume_run(path: Path) -> "RunResult":
    """Go on with an interrupted run."""
    from navtool.cli.progress import WorkProgress
    from navtool.train.run import resume

    with WorkProgress("epochs") as progress:
        return resume(path, progress=progress)


def print_run(result: "RunResult", *, as_json: bool = False) -> None:
    """What a run did, and where it lies."""
    from navtool.base.plain import plain
    from navtool.cli.console import console, print_json, print_notes

    if as_json:
        print_json(plain(result))
        return
    out = console()
    print_notes(result.remarks.notes)
    out.print(
        f"{result.epochs} epochs in {result.seconds:.1f} s, {result.samples_per_s:.1f} samples/s, "
        f"best validation loss {result.best_val_loss:.4f}",
        markup=False,
    )
    out.print(f"run: {result.run}", markup=False)
