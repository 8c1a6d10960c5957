"""The folder of a training run and the files in it."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from navtool.base.files import read_json, write_json
from navtool.base.plain import plain
from navtool.train.config import TrainConfig
from navtool.train.errors import TrainError
from navtool.train.models import name_of, read_config, unknown_model

RUN_SCHEMA = 1
"""Raised whenever a file of a run changes its meaning; other versions are refused."""

_CURE = "name the folder that `navtool train` wrote"
_DAMAGED = "train again, or restore the file"


@dataclass(frozen=True, slots=True)
class RunFolder:
    """Where a run keeps what; nothing is read or written until it is asked for."""

    path: Path

    @property
    def checkpoints(self) -> Path:
        """Folder of the checkpoints."""
        return self.path / "checkpoints"

    @property
    def last(self) -> Path:
        """Checkpoint after the last whole epoch."""
        return self.checkpoints / "last.ckpt"

    @property
    def best(self) -> Path:
        """Checkpoint of the smallest validation loss."""
        return self.checkpoints / "best.ckpt"

    @property
    def config(self) -> Path:
        """The resolved configuration."""
        return self.path / "config.json"

    @property
    def lineage(self) -> Path:
        """What the run was made from."""
        return self.path / "lineage.json"

    @property
    def metrics(self) -> Path:
        """The figures of the finished run."""
        return self.path / "metrics.json"

    @property
    def tensorboard(self) -> Path:
        """TensorBoard's event files."""
        return self.path / "tensorboard"

    def exists(self) -> bool:
        """Whether a run was begun here."""
        return self.config.is_file()

    def write_config(self, config: TrainConfig) -> None:
        """Write ``config.json``."""
        write_json(self.config, {"schema_version": RUN_SCHEMA, "model": name_of(config.model), "config": plain(config)})

    def write_lineage(self, lineage: Mapping[str, object]) -> None:
        """Write ``lineage.json``."""
        write_json(self.lineage, plain(lineage))

    def write_metrics(self, metrics: Mapping[str, object]) -> None:
        """Write ``metrics.json``."""
        write_json(self.metrics, plain(metrics))

    def read_config(self) -> TrainConfig:
        """The configuration of the run.

        Raises:
            TrainError: There is no run, or one of an unknown model or another schema version.
            DatasetsError: The file cannot be read.
        """
        if not self.path.is_dir():
            raise TrainError("no such folder", where=self.path, cure=_CURE)
        if not self.exists():
            raise TrainError("is not a training run: it has no config.json", where=self.path, cure=_CURE)
        content = read_json(self.config, _DAMAGED)
        version, model = content.get("schema_version"), content.get("model")
        if version != RUN_SCHEMA:
            raise TrainError(
                f"a run of schema version {version}; this navtool reads {RUN_SCHEMA}",
                where=self.config,
                cure="train again, or use the navtool that wrote it",
            )
        if fault := unknown_model(model):
            cure = "use the navtool that wrote it"
            raise TrainError(f"a run of another navtool: {fault}", where=self.config, cure=cure)
        return read_config(str(model), content.get("config"), where=self.config)

    def read_lineage(self) -> dict[str, Any]:
        """What the run was made from.

        Raises:
            DatasetsError: The file is missing or damaged.
        """
        return read_json(self.lineage, _DAMAGED)

    def read_metrics(self) -> dict[str, Any] | None:
        """The figures of the finished run; None where it has not finished.

        Raises:
            DatasetsError: The file is damaged.
        """
        return read_json(self.metrics, _DAMAGED) if self.metrics.is_file() else None
