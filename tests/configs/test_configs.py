"""Every configuration composes, every option stands in a dataclass, every preset is a valid robot."""

from dataclasses import replace
from pathlib import Path

import pytest

from navtool.base.lineage import config_hash
from navtool.base.setting_error import SettingError
from navtool.cli.compose import UsageError, compose, quoted
from navtool.configs.ingest_job import IngestJob
from navtool.configs.intensity_map_job import IntensityMapJob
from navtool.configs.schema import SCHEMAS, config_folder
from navtool.configs.train_job import TrainJob
from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.labels.config import LabelConfig
from navtool.datasets.robot.config import RobotConfig
from navtool.methods.intensity_map.config import MapRunConfig
from navtool.sim.record.config import SimulationConfig
from navtool.sim.world.scenario import load_scenario
from navtool.train.config import TrainConfig
from navtool.train.graspe.config import GraspeConfig


def _options(group: str) -> list[str]:
    return sorted(path.stem for path in (config_folder() / group).glob("*.yaml"))


def test_every_configuration_has_a_schema_and_a_file() -> None:
    assert sorted(SCHEMAS) == sorted(path.stem for path in config_folder().glob("*.yaml"))


def test_defaults_stand_in_the_dataclasses_alone() -> None:
    assert compose("ingest", [], IngestJob).config() == IngestConfig()
    assert compose("label", [], LabelConfig) == LabelConfig()
    assert compose("intensity_map", [], IntensityMapJob).config() == MapRunConfig()
    assert compose("train", ["dataset=x"], TrainJob).config() == TrainConfig(model=GraspeConfig())


@pytest.mark.parametrize("name", _options("robot"))
def test_every_robot_composes(name: str) -> None:
    robot = compose("ingest", [f"robot={name}"], IngestJob).robot
    assert isinstance(robot, RobotConfig)
    assert robot.name != RobotConfig().name


@pytest.mark.parametrize("name", _options("sensor"))
def test_every_sensor_composes_and_overrides_win(name: str) -> None:
    config = compose("intensity_map", [f"sensor={name}"], IntensityMapJob)
    assert config.sensor == name
    assert config.map.layers.full_scale <= config.largest_intensity
    described = (config_folder().parent / "docs" / "intensity_maps.md").read_text()
    assert f"| `{name}` | {config.map.layers.full_scale:g} | {config.largest_intensity:.0f} |" in described
    own = compose("intensity_map", [f"sensor={name}", "map.layers.full_scale=0.5"], IntensityMapJob)
    assert own.map.layers.full_scale == 0.5
    assert own.largest_intensity == config.largest_intensity


@pytest.mark.parametrize("name", _options("scenario"))
def test_every_scenario_composes_as_its_file_says(name: str) -> None:
    config = compose("simulate", [f"scenario={name}"], SimulationConfig)
    assert config.scenario == load_scenario(config_folder() / "scenario" / f"{name}.yaml")
    assert config == replace(SimulationConfig(), scenario=config.scenario)


@pytest.mark.parametrize("group", ["experiment", "debug"])
def test_every_experiment_composes_and_changes_something(group: str) -> None:
    plain = config_hash(TrainConfig(model=GraspeConfig()))
    for name in _options(group):
        job = compose("train", ["dataset=x", f"{group}={name}"], TrainJob)
        assert config_hash(job.config()) != plain, name


def test_the_papers_settings_are_the_defaults() -> None:
    config = TrainConfig(model=GraspeConfig())
    assert (config.optimizer.learning_rate, config.optimizer.weight_decay) == (0.002, 0.00025)
    assert (config.trainer.epochs, GraspeConfig().graph.edge_decay) == (30, 15.0)
    paper = compose("train", ["dataset=x", "experiment=graspe_paper"], TrainJob)
    assert paper.trainer.epochs == 1000


@pytest.mark.parametrize(
    ("overrides", "said"),
    [
        (["fbs=5"], "fbs"),
        (["fps=many"], "many"),
        (["fps=0"], "0 Hz is outside"),
        (["sync.camera.tolerance_s=-1"], "camera.tolerance_s"),
        (["robot.base_height_m=90"], "base_height_m"),
        (["robot=unknown"], "husky"),
        (["fps"], "fps"),
        (["fps=[1"], "fps"),
    ],
)
def test_wrong_overrides_say_what_is_wrong(overrides: list[str], said: str) -> None:
    with pytest.raises((SettingError, UsageError)) as caught:
        compose("ingest", overrides, IngestJob)
    assert said in f"{caught.value.what} {caught.value.where} {caught.value.cure}"


@pytest.mark.parametrize("value", ["plain", "with space", "it's", "a,b", "x=y", "{parent}", "back\\slash"])
def test_quoted_values_arrive_as_they_are(value: str) -> None:
    assert compose("ingest", [f"place={quoted(value)}"], IngestJob).place == value


def test_the_config_folder_is_the_installed_one() -> None:
    assert (config_folder() / "ingest.yaml").is_file()
    assert Path(config_folder()).is_absolute()
