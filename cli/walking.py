"""What the commands share that walk along recordings with a method."""

from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from navtool.datasets.ingest.config import Merge
    from navtool.datasets.robot.config import RobotConfig
    from navtool.datasets.streams.config import SyncConfig
    from navtool.methods.along.report import Report
    from navtool.methods.along.source import Input, Source


class WalkJob(Protocol):
    """The configuration of such a command."""

    robot: "RobotConfig"
    merge: "Merge"
    sync: "SyncConfig"

    def config(self) -> object:
        """The settings of the method alone."""


@dataclass(frozen=True, slots=True, kw_only=True)
class WalkCall:
    """How such a command was called."""

    command: str
    """For messages."""
    arguments: Sequence[str]
    """Inputs and overrides."""
    out: Path | None
    truth: Path | None
    episode: int | None
    robot: str | None
    cfg: str | None
    settings: Path | None = None
    """A file of settings, over which overrides win."""


def walk[P: "Report"](call: WalkCall, method: str, job_type: type[WalkJob], report_type: type[P]) -> P | None:
    """Walk along the inputs of a call with a method of `METHODS`; None where only the configuration was asked for.

    Raises:
        UsageError: The command was not called rightly.
        DatasetsError: The method cannot be walked along an input, with the reason.
    """
    from pkgutil import resolve_name

    from navtool.base.output_folder import OutputFolder
    from navtool.cli.arguments import local_path, require_there, split_overrides
    from navtool.cli.compose import UsageError, print_config, wrong_call
    from navtool.cli.progress import WorkProgress
    from navtool.datasets.ingest.config import Merge
    from navtool.methods.along.run import run_along
    from navtool.methods.along.source import Input
    from navtool.methods.table import method_row

    row = method_row(method)
    inputs, overrides = split_overrides(call.arguments)
    job = _job(call, method, overrides, job_type)
    if call.cfg is not None:
        print_config(job, call.cfg)
        return None
    if not inputs or (len(inputs) > 1 and not row.several):
        named = f"{len(inputs)} inputs were named" if inputs else "no recording or data set was named"
        raise UsageError(named, where=call.command, cure=row.inputs)
    if call.truth is not None and len(inputs) > 1:
        cure = "fit one recording with its annotations"
        raise UsageError("one --truth for several inputs", where=call.command, cure=cure)
    if call.out is None:
        raise UsageError("no folder was named", where=call.command, cure="pass --out FOLDER")
    require_there(call.truth)
    made = resolve_name(row.method)(job.config())
    with wrong_call():
        OutputFolder(call.out, made.kind).refuse_other()
    merged = job.merge is Merge.folder
    named_inputs = [Input(local_path(text), call.episode, job.robot, merged, job.sync) for text in inputs]
    with ExitStack() as opened:
        sources = [opened.enter_context(_open(one)) for one in named_inputs]
        for dataset in (one.path for one in named_inputs if one.is_dataset):
            _refuse_robot(call, overrides, dataset)
        progress = opened.enter_context(WorkProgress("inputs" if row.several else "runs"))
        report = run_along(sources, made, call.out, progress, call.truth)
    if not isinstance(report, report_type):
        raise TypeError(f"{method} reports a {type(report).__name__}")
    return report


def _job(call: WalkCall, method: str, overrides: Sequence[str], job_type: type[WalkJob]) -> WalkJob:
    from navtool.cli.compose import UsageError, refuse_unknown_choices
    from navtool.cli.robots import job_with_robot
    from navtool.cli.settings_file import settings_overrides

    refuse_unknown_choices("sensor", overrides, "sensor preset")
    if call.settings is not None and any(override.startswith("sensor=") for override in overrides):
        cure = "leave sensor= out: the settings hold the scale of the sensor that they were fitted to"
        raise UsageError("--settings and sensor= both name a sensor", where=call.command, cure=cure)
    return job_with_robot(method, call.robot, [*settings_overrides(call.settings), *overrides], job_type)


@contextmanager
def _open(named: "Input") -> Iterator["Source"]:
    """An input, open; an episode that there is none of is a wrong call."""
    from navtool.cli.compose import wrong_call
    from navtool.methods.along.source import EpisodeError

    with ExitStack() as opened:
        try:
            source = opened.enter_context(named.open())
        except EpisodeError:
            with wrong_call():
                raise
        yield source


def _refuse_robot(call: WalkCall, overrides: Sequence[str], dataset: Path) -> None:
    """Refuse a robot, or settings of time, for a data set: both were decided when it was ingested."""
    from navtool.cli.compose import UsageError

    if call.robot is not None or any(override.startswith("robot") for override in overrides):
        raise UsageError("the data set knows its own robot", where=dataset, cure="leave --robot and robot. out")
    if any(override.startswith("sync.") for override in overrides):
        raise UsageError("the data set has its clocks already", where=dataset, cure="leave sync. out")
