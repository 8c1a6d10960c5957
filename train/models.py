"""The table of models: every command that trains, judges, exports or verifies one finds it here."""

from pathlib import Path

from navtool.base.from_plain import did_you_mean, from_plain
from navtool.base.setting_error import SettingError
from navtool.train.config import TrainConfig
from navtool.train.errors import TrainError
from navtool.train.graspe.kind import GRASPE
from navtool.train.model_config import ModelConfig
from navtool.train.model_kind import AnyKind

MODELS: dict[str, AnyKind] = {
    "graspe": GRASPE,
}
"""Kinds of models by name: that of the Hydra choice ``model=``, of checkpoints and of artefacts."""


def kind_of(config: ModelConfig) -> AnyKind:
    """The kind of model that the settings are of."""
    return MODELS[name_of(config)]


def name_of(config: ModelConfig) -> str:
    """The name of the kind of model that the settings are of."""
    return next(name for name, kind in MODELS.items() if kind.config is type(config))


def unknown_model(name: object) -> str | None:
    """What is wrong with a model's name, the known ones listed; None where it is one of them."""
    if name in MODELS:
        return None
    return f"there is no model {name!r}{did_you_mean(str(name), list(MODELS))}; known are {', '.join(sorted(MODELS))}"


def read_config(name: str, content: object, *, where: Path) -> TrainConfig:
    """A run's configuration from its plain form; the name is one of the table's.

    Raises:
        TrainError: A key or value is none of this configuration's.
    """
    try:
        return from_plain(TrainConfig, content, where=where, concrete={ModelConfig: MODELS[name].config})
    except SettingError as error:
        raise TrainError(f"is damaged ({error.what})", where=where, cure="use the navtool that wrote it") from error
