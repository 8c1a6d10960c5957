from pathlib import Path

import pytest

from navtool.base.errors import NavtoolError
from navtool.base.setting_error import SettingError
from navtool.configs.schema import config_folder
from navtool.sim.errors import SimError
from navtool.sim.world.scenario import LightConfig, RegionConfig, RoomConfig, Scatter, ScenarioConfig, load_scenario

FILES = sorted((config_folder() / "scenario").glob("*.yaml"))
PAPERS = {f"{paper}_{number}" for paper in ("graspe", "amco", "mim") for number in range(1, 5)}


def test_every_scenario_of_the_papers_is_there() -> None:
    assert {path.stem for path in FILES} == PAPERS | {"demo"}


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_a_scenario_bears_the_name_of_its_file(path: Path) -> None:
    assert load_scenario(path).name == path.stem


def test_the_papers_low_light_is_low() -> None:
    lux = {path.stem: load_scenario(path).light.illuminance_lux for path in FILES}
    assert max(lux["graspe_4"], lux["amco_3"]) < 0.01 * lux["graspe_1"]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("treees: {count: 3}", r"treees.*did you mean 'trees'"),
        ("trees: {count: many}", r"trees\.count.*whole number"),
        ("trees: {count: 1000}", r"trees\.count: 1000 is outside \[0, 400\]"),
        ("ground: lava", r"lava.*\n.*concrete"),
        ("regions: [{surface: sand, share: 2}]", r"share"),
        ("course_m: 90", r"course_m: 90 m is outside"),
        ("room: {length_m: 8}", r"does not fit"),
        ("light: {sun_share: 1.0}", r"sun_share: 1 is outside \[0, 0\.9\]"),
        ("[", r"is not YAML"),
    ],
)
def test_what_is_wrong_in_a_file_is_named(tmp_path: Path, text: str, said: str) -> None:
    path = tmp_path / "wrong.yaml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(NavtoolError, match=said) as caught:
        load_scenario(path)
    assert str(path) in str(caught.value)


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(SimError, match=r"cannot be read"):
        load_scenario(tmp_path / "none.yaml")


def test_values_out_of_range_are_refused() -> None:
    for make in (
        lambda: Scatter(size=[0.8, 0.2]),
        lambda: Scatter(from_m=1.0, to_m=0.0),
        lambda: RegionConfig(surface="bark"),
        lambda: RoomConfig(height_m=1.0),
        lambda: LightConfig(illuminance_lux=0.0),
        lambda: ScenarioConfig(cell_m=0.01),
    ):
        with pytest.raises(SettingError, match=r"."):
            make()
