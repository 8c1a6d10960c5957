"""Settings that make no map are refused, and the message names what is wrong."""

from collections.abc import Callable

import pytest

from navtool.base.setting_error import SettingError
from navtool.pipeline.intensity_map.config import (
    GlassConfig,
    GridConfig,
    InflationConfig,
    IntensityMapConfig,
    LayerConfig,
    ObstacleConfig,
)


@pytest.mark.parametrize(
    ("make", "named"),
    [
        (lambda: GridConfig(cells=201), "201"),
        (lambda: GridConfig(cells=8), "8"),
        (lambda: GridConfig(cell_m=0.0), "cell_m"),
        (lambda: LayerConfig(height_m=0.0), "height_m"),
        (lambda: LayerConfig(full_scale=float("nan")), "full_scale"),
        (lambda: LayerConfig(flat_rad=0.5), "flat_rad"),
        (lambda: LayerConfig(ground_margin_m=-0.1), "ground_margin_m"),
        (lambda: ObstacleConfig(threshold=0.0), "threshold"),
        (lambda: ObstacleConfig(pooling_cells=11), "pooling_cells"),
        (lambda: GlassConfig(points=2), "points"),
        (lambda: GlassConfig(incidence_rad=2.0), "incidence_rad"),
        (lambda: GlassConfig(decay_s=0.0), "decay_s"),
        (lambda: InflationConfig(size_cells=10), "size_cells"),
        (lambda: InflationConfig(size_cells=3, minor_cells=2), "minor_cells"),
        (lambda: IntensityMapConfig(robot_radius_m=0.0), "robot_radius_m"),
        (lambda: IntensityMapConfig(grid=GridConfig(cells=16), inflation=InflationConfig(size_cells=17)), "larger"),
    ],
)
def test_settings_that_make_no_map_are_refused(make: Callable[[], object], named: str) -> None:
    with pytest.raises(SettingError, match=named):
        make()
