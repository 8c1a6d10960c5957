"""What a sweep leaves behind: one table of its runs."""

import json
from pathlib import Path
from typing import Any

from hydra.experimental.callback import Callback
from omegaconf import DictConfig, OmegaConf

from navtool.base.files import write_json
from navtool.cli.console import console, print_table

SUMMARY = "summary.json"


class SweepSummary(Callback):
    """After the last job, gathers the jobs' overrides and metrics into ``summary.json`` and prints them."""

    def on_multirun_end(self, config: DictConfig, **_: Any) -> None:
        """Write and print the summary of the sweep in ``hydra.sweep.dir``."""
        folder = Path(config.hydra.sweep.dir)
        jobs = sorted((path for path in folder.iterdir() if (path / ".hydra").is_dir()), key=_number)
        rows = [_row(job) for job in jobs]
        write_json(folder / SUMMARY, {"jobs": rows})
        print_table(
            "Sweep",
            ("job", "overrides", "best validation loss", "epochs"),
            ((row["job"], " ".join(row["overrides"]), row["best_val_loss"], row["epochs"]) for row in rows),
        )
        console().print(f"summary: {folder / SUMMARY}", markup=False)


def _number(path: Path) -> tuple[int, str]:
    return (int(path.name), "") if path.name.isdigit() else (1 << 30, path.name)


def _row(job: Path) -> dict[str, Any]:
    overrides = list(OmegaConf.load(job / ".hydra" / "overrides.yaml"))
    result = job / "metrics.json"
    metrics = json.loads(result.read_text(encoding="utf-8")) if result.is_file() else {}
    return {
        "job": job.name,
        "overrides": [str(entry) for entry in overrides if not str(entry).startswith("dataset=")],
        "finished": result.is_file(),
        "best_val_loss": metrics.get("best_val_loss"),
        "epochs": metrics.get("epochs"),
    }
