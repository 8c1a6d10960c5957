"""The table of models: complete, and the only place outside of its folder that names one."""

from pathlib import Path

import pytest

from navtool.cli.compose import compose
from navtool.configs.schema import config_folder
from navtool.configs.train_job import TrainJob
from navtool.train.contract import TensorSpec
from navtool.train.graspe.config import GraspeConfig
from navtool.train.graspe.kind import GRASPE
from navtool.train.models import MODELS, kind_of, name_of, unknown_model

ROOT = config_folder().parent


def test_each_model_is_a_choice_whose_configuration_names_it() -> None:
    assert sorted(MODELS) == sorted(path.stem for path in (config_folder() / "model").glob("*.yaml"))
    for name, kind in MODELS.items():
        config = compose("train", ["dataset=x", f"model={name}"], TrainJob).model
        assert (name_of(config), kind_of(config)) == (name, kind)
    assert len({kind.config for kind in MODELS.values()}) == len(MODELS)


def test_only_the_table_and_its_own_folder_name_a_model() -> None:
    sources = [path.relative_to(ROOT) for part in ("train", "export") for path in (ROOT / part).rglob("*.py")]
    assert len(sources) > 40
    for name in MODELS:
        allowed = {Path("train/models.py"), *(path for path in sources if path.is_relative_to(f"train/{name}"))}
        naming = [path for path in sources if name in (ROOT / path).read_text(encoding="utf-8").lower()]
        assert set(naming) <= allowed


def test_an_unknown_name_gets_the_known_ones_and_the_nearest() -> None:
    assert unknown_model("graspe") is None
    assert unknown_model("grasp") == "there is no model 'grasp' (did you mean 'graspe'?); known are graspe"
    assert unknown_model(None) == "there is no model None; known are graspe"


def test_a_size_below_one_is_no_size() -> None:
    with pytest.raises(ValueError, match="at least 1"):
        TensorSpec("image", ("batch", 0), "uint8", "1", None, "")


def test_the_batch_holds_the_inputs_of_the_contract() -> None:
    config = GraspeConfig(image_height=48, image_width=64)
    task, source = GRASPE.task, GRASPE.stand_in(config)
    job = compose("train", ["dataset=x", "model.image_height=48", "model.image_width=64"], TrainJob).config()
    inputs = GRASPE.inputs(task.samples(source, [0], job)[0])
    for spec, tensor in zip(GRASPE.contract(config).inputs, inputs, strict=True):
        assert tuple(tensor.shape) == spec.shape[1:]
        assert str(tensor.dtype) == f"torch.{spec.dtype}"
