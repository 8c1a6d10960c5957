"""Running a command's work as a Hydra application: multirun, launchers and sweepers plug in."""

import os
import sys
from collections.abc import Callable, Sequence
from functools import wraps
from math import nan
from pathlib import Path
from shutil import rmtree
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from omegaconf import DictConfig


def _remove_unused(folder: Path) -> None:
    """Remove a run's folder that holds nothing but Hydra's record of the settings."""
    if {entry.name for entry in folder.iterdir()} <= {".hydra"}:
        rmtree(folder)


def run_through_hydra(job: "Callable[[DictConfig], float]", config: str, arguments: Sequence[str]) -> None:
    """Run a job through Hydra with these command-line arguments.

    Raises:
        UsageError: If an override is wrong.
        NavtoolError: What the job itself raises.
    """
    import hydra
    from hydra.core.global_hydra import GlobalHydra
    from hydra.core.hydra_config import HydraConfig
    from hydra.types import RunMode

    from navtool.base.errors import NavtoolError
    from navtool.cli.compose import usage_errors
    from navtool.configs.schema import config_folder, register

    failed: list[NavtoolError] = []

    @wraps(job)
    def task(composed: "DictConfig") -> float:
        try:
            return job(composed)
        except NavtoolError as error:
            if HydraConfig.get().mode is not RunMode.RUN:
                raise
            failed.append(error)  # of a single job, Hydra would print a line of its own before it
            _remove_unused(Path(HydraConfig.get().runtime.output_dir))
            return nan

    register(config)
    GlobalHydra.instance().clear()
    before, full_error = sys.argv, os.environ.get("HYDRA_FULL_ERROR")
    sys.argv = [f"navtool {config}", *arguments]
    os.environ["HYDRA_FULL_ERROR"] = "1"  # Hydra raises instead of printing a traceback and leaving the process
    try:
        with usage_errors(config):
            hydra.main(version_base="1.3", config_path=str(config_folder()), config_name=config)(task)()
    finally:
        sys.argv = before
        if full_error is None:
            del os.environ["HYDRA_FULL_ERROR"]
        else:
            os.environ["HYDRA_FULL_ERROR"] = full_error
    if failed:
        raise failed[0]
