"""The network's configuration: a structured config, the paper's sizes, faults told together."""

from typing import Any

import pytest
from omegaconf import OmegaConf

from navtool.base.setting_error import SettingError
from navtool.train.graspe.config import GraspeConfig
from navtool.train.graspe.graspe import Graspe


def test_defaults_are_the_papers_sizes() -> None:
    config = GraspeConfig()
    assert config.graph.sizes() == [40, 40, 20, 20]
    assert (config.horizon, config.history, config.graph_channels, config.graph.edge_decay) == (10, 50, 16, 15.0)
    assert (config.image_width, config.image_height) == (320, 240)
    assert config.point_widths == [64, 64, 64, 128, 1024]


def test_survives_omegaconf_both_ways() -> None:
    structured = OmegaConf.structured(GraspeConfig)
    composed = OmegaConf.merge(structured, OmegaConf.from_dotlist(["graph.edge_decay=9.5", "self_loop_weight=1.0"]))
    config = OmegaConf.to_object(composed)
    assert isinstance(config, GraspeConfig)
    assert config.graph.edge_decay == 9.5
    assert config.self_loop_weight == 1.0
    assert OmegaConf.to_object(structured) == GraspeConfig()


@pytest.mark.parametrize(
    ("option", "value"),
    [
        ("horizon", 0),
        ("history", 19),
        ("image_height", 47),
        ("image_width", 47),
        ("v_max_mps", 0.0),
        ("omega_max_radps", -1.0),
        ("point_range_m", float("nan")),
        ("cbam_reduction", 0),
        ("point_widths", [64]),
        ("point_widths", [64, 0]),
        ("point_hidden", [-1]),
        ("point_transform_widths", []),
        ("velocity_channels", 0),
        ("trajectory_channels", [8, 16]),
        ("trajectory_channels", [8, 16, 32, 64]),
        ("graph_channels", 0),
        ("attention_heads", 0),
        ("self_loop_weight", 1.5),
        ("dense_hidden", 0),
        ("dropout", 1.0),
        ("dropout", -0.1),
    ],
)
def test_refuses_what_makes_no_network_and_names_it(option: str, value: Any) -> None:
    with pytest.raises(SettingError, match=option):
        GraspeConfig(**{option: value})


def test_tells_all_faults_at_once() -> None:
    with pytest.raises(SettingError, match=r"horizon: 0.*dropout: 2 is"):
        GraspeConfig(horizon=0, dropout=2.0)


def test_the_smallest_allowed_network_can_be_built() -> None:
    Graspe(
        GraspeConfig(
            horizon=1,
            history=20,
            image_height=48,
            image_width=48,
            point_widths=[1, 1],
            point_hidden=[],
            point_transform_widths=[1],
            point_transform_hidden=[],
            velocity_channels=1,
            trajectory_channels=[1, 1, 1],
            graph_channels=1,
            dense_hidden=1,
        )
    )
