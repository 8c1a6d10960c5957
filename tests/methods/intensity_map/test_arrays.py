"""Maps read back from their files by numpy alone."""

from pathlib import Path

import numpy as np
from mapped_factory import mapped_anything

from navtool.methods.along.array_files import ArrayFiles
from navtool.methods.along.writers import Outcome
from navtool.methods.intensity_map.arrays import map_arrays
from navtool.methods.intensity_map.mapped import MappedSweep


def outcome(mapped: MappedSweep) -> Outcome[MappedSweep]:
    return Outcome(mapped.number, mapped.sweep.stamp_ns, 0.0, mapped)


def test_a_map_is_read_back_without_pickle(tmp_path: Path) -> None:
    mapped, alone = mapped_anything(0), mapped_anything(7, place=None)
    writer = ArrayFiles(tmp_path / "arrays", map_arrays)
    writer.add(outcome(mapped))
    writer.add(outcome(alone))
    assert sorted(path.name for path in (tmp_path / "arrays").iterdir()) == ["000000.npz", "000007.npz"]
    with np.load(tmp_path / "arrays" / "000000.npz", allow_pickle=False) as found:
        np.testing.assert_array_equal(found["layers"], mapped.values)
        np.testing.assert_array_equal(found["points"], mapped.map.layers.points)
        np.testing.assert_array_equal(found["classes"], mapped.classes)
        np.testing.assert_array_equal(found["transparent"], mapped.map.transparent)
        np.testing.assert_array_equal(found["plan"], mapped.map.plan)
        np.testing.assert_array_equal(found["odom_sensor"], mapped.sweep.odom_sensor)
        assert int(found["stamp_ns"]) == mapped.sweep.stamp_ns
        assert float(found["goal_rad"]) == mapped.goal_rad
        assert found["points"].sum() > 1000
        # cell (r, c) begins at origin + (r, c) cell_m
        np.testing.assert_allclose(found["origin_m"] + found["cell_m"] * np.array(found["classes"].shape), [5.0, 5.0])
    with np.load(tmp_path / "arrays" / "000007.npz", allow_pickle=False) as found:
        assert np.isnan(found["odom_sensor"]).all()


def test_the_same_map_gives_the_same_bytes(tmp_path: Path) -> None:
    for name in ("one", "two"):
        ArrayFiles(tmp_path / name, map_arrays).add(outcome(mapped_anything(0)))
    assert (tmp_path / "one" / "000000.npz").read_bytes() == (tmp_path / "two" / "000000.npz").read_bytes()
