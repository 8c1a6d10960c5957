"""The command line: the tree of commands, and what becomes of errors."""

import logging
import sys
from typing import NoReturn

import typer

from navtool.base.errors import NavtoolError, OccupiedError
from navtool.base.setting_error import SettingError
from navtool.cli.check import check
from navtool.cli.compact import compact
from navtool.cli.console import print_error, print_json
from navtool.cli.delete import delete
from navtool.cli.demo import demo
from navtool.cli.evaluate import evaluate
from navtool.cli.export import export
from navtool.cli.fit import fit
from navtool.cli.ingest import ingest
from navtool.cli.inspect import inspect
from navtool.cli.intensity_map import intensity_map
from navtool.cli.label import label
from navtool.cli.merge import merge
from navtool.cli.migrate import migrate
from navtool.cli.simulate import simulate
from navtool.cli.split import split
from navtool.cli.train import train
from navtool.cli.verify import verify

INTERRUPTED = 130
"""Exit code after Ctrl-C."""

app = typer.Typer(
    name="navtool",
    help="From raw robot recordings to verified navigation models.",
    epilog=(
        "Options say where and how, trailing key=value overrides say what. "
        "Exit codes: 0 ok; 1 failed, or an input that cannot be read; 2 wrong call."
    ),
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _print_version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        typer.echo(f"navtool {version('navtool')}")
        raise typer.Exit


@app.callback()
def options(
    _version: bool = typer.Option(
        False, "--version", callback=_print_version, is_eager=True, help="Print the version."
    ),
    verbose: bool = typer.Option(False, "--verbose", "-v", help="Log what happens inside to standard error."),
) -> None:
    """From raw robot recordings to verified navigation models."""
    level = logging.DEBUG if verbose else logging.ERROR
    logging.basicConfig(level=level, format="%(levelname)s %(name)s: %(message)s")


for command in (
    *(inspect, ingest, label, check, delete, split, merge, compact, migrate),
    *(train, evaluate, export, verify, intensity_map, simulate, demo),
):
    app.command()(command)
app.add_typer(fit)


def main() -> None:
    """Run the command line; every error of ours becomes one message and an exit code."""
    try:
        app()
    except NavtoolError as error:
        from navtool.cli.compose import UsageError

        _leave(error, 2 if isinstance(error, OccupiedError | SettingError | UsageError) else 1)
    except ModuleNotFoundError as error:
        from navtool.cli.extras import missing_extra

        if (refusal := missing_extra(error)) is None:
            raise
        _leave(refusal, 1)
    except SystemExit as left:
        if left.code == INTERRUPTED:
            what = "interrupted; what was reported as done stays, run the same command again to go on"
            _leave(NavtoolError(what), INTERRUPTED)
        # Typer has printed what is wrong with an option already
        wrong = getattr(left.__context__, "format_message", None)
        if wrong is not None and _asked_for_json():
            _print_json_error(NavtoolError(wrong()), left.code)
        raise


def _leave(error: NavtoolError, code: int) -> NoReturn:
    """Say what is wrong, to a program too where one asked, and end."""
    print_error(str(error))
    if _asked_for_json():
        _print_json_error(error, code)
    sys.exit(code)


def _asked_for_json() -> bool:
    return "--json" in sys.argv[1:]


def _print_json_error(error: NavtoolError, code: object) -> None:
    print_json({"error": {"what": error.what, "where": error.where, "cure": error.cure, "exit_code": code}})
