"""The table of configurations that Hydra composes: which dataclass stands behind which YAML file.

A default stands once, in the dataclass beside the code that it configures; the YAML files say only what differs.
"""

from pathlib import Path
from pkgutil import resolve_name
from typing import NamedTuple

from hydra.core.config_store import ConfigStore


class Schema(NamedTuple):
    """A dataclass under the name by which a YAML file's defaults list calls it."""

    name: str
    dataclass: str
    """``module:class``, imported when its configuration is composed: only training loads torch."""
    group: str | None = None


SCHEMAS: dict[str, tuple[Schema, ...]] = {
    "ingest": (
        Schema("ingest_schema", "navtool.configs.ingest_job:IngestJob"),
        Schema("robot_schema", "navtool.datasets.robot.config:RobotConfig", "robot"),
    ),
    "intensity_map": (
        Schema("intensity_map_schema", "navtool.configs.intensity_map_job:IntensityMapJob"),
        Schema("robot_schema", "navtool.datasets.robot.config:RobotConfig", "robot"),
    ),
    "intensity_threshold": (
        Schema("intensity_threshold_schema", "navtool.configs.intensity_threshold_job:IntensityThresholdJob"),
        Schema("robot_schema", "navtool.datasets.robot.config:RobotConfig", "robot"),
    ),
    "label": (Schema("label_schema", "navtool.datasets.labels.config:LabelConfig"),),
    "simulate": (
        Schema("simulate_schema", "navtool.sim.record.config:SimulationConfig"),
        Schema("scenario_schema", "navtool.sim.world.scenario:ScenarioConfig", "scenario"),
    ),
    "train": (Schema("train_schema", "navtool.configs.train_job:TrainJob"),),
}
"""The configurations by the names of their YAML files. Training has a schema a model besides: see `register`."""


def config_folder() -> Path:
    """The folder of the YAML files, wherever navtool is installed."""
    return Path(__file__).resolve().parent


def register(config: str) -> None:
    """Make the schemas of a configuration known to Hydra; twice does no harm.

    Each row of the table of models has its own, such as ``graspe_schema`` in the group ``model``.
    """
    store = ConfigStore.instance()
    for schema in SCHEMAS[config]:
        store.store(name=schema.name, node=resolve_name(schema.dataclass), group=schema.group)
    if config == "train":
        for name, kind in resolve_name("navtool.train.models:MODELS").items():
            store.store(name=f"{name}_schema", node=kind.config, group="model")
