"""Maps of whole runs: recordings in every container, data sets, bad inputs, odometry that jumps or is not there."""

import csv
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hashes import hashes
from intensity_drive import HEIGHT_M, cloud_fields, intensity_drive
from intensity_scene import Stand, scan_scene
from noted import noted
from recording_factory import Entry
from walking import intensity_maps

from navtool.base.errors import DatasetsError
from navtool.base.progress import Silent
from navtool.base.setting_error import SettingError
from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.ingest.ingest import ingest
from navtool.datasets.robot.config import RobotConfig
from navtool.methods.along.source import Input
from navtool.methods.intensity_map.config import MapRunConfig, OutputConfig, SensorHeight
from navtool.methods.intensity_map.report import MapReport
from navtool.pipeline.intensity_map.config import GridConfig, IntensityMapConfig, ObstacleConfig
from navtool.pipeline.intensity_map.obstacles import CellClass

ARRAYS = OutputConfig(arrays_every=1, pictures_every=0, mcap_every=0, video_every=0)
SMALL = IntensityMapConfig(grid=GridConfig(cells=100, cell_m=0.1))


def settings(**changes: Any) -> MapRunConfig:
    given: dict[str, Any] = {"outputs": ARRAYS, "map": SMALL} | changes
    return MapRunConfig(**given)


def maps_of(path: Path, out: Path, config: MapRunConfig | None = None, **chosen: Any) -> MapReport:
    return intensity_maps(Input(path, **chosen), out, config or settings())


def classes_in(out: Path, number: int) -> np.ndarray[Any, np.dtype[np.uint8]]:
    with np.load(out / "arrays" / f"{number:06d}.npz") as found:
        return np.asarray(found["classes"])


def changed(entries: list[Entry], which: slice, change: Callable[[dict[str, Any]], dict[str, Any]]) -> list[Entry]:
    """The messages with some of their clouds changed."""
    clouds = [number for number, entry in enumerate(entries) if entry[0] == "/points"][which]
    return [
        (topic, kind, record_ns, {**fields, **change(dict(fields))})
        if number in clouds
        else (topic, kind, record_ns, fields)
        for number, (topic, kind, record_ns, fields) in enumerate(entries)
    ]


def with_intensity(*values: float) -> Callable[[dict[str, Any]], dict[str, Any]]:
    """Intensities that the points have in turn."""

    def change(fields: dict[str, Any]) -> dict[str, Any]:
        table = np.frombuffer(fields["data"].tobytes(), "<f4").reshape(fields["width"], -1)
        return cloud_fields(table[:, :3], np.resize(np.array(values), len(table)), table[:, 4])

    return change


def made(folder: Path) -> dict[str, str]:
    return {name: sha256 for name, sha256 in hashes(folder).items() if name != "lineage.json"}


@pytest.mark.parametrize("container", ["ros1", "db3", "mcap"])
def test_a_recording_and_its_data_set_give_the_same_files(
    write_recording: Callable[..., Path], tmp_path: Path, container: str
) -> None:
    path = write_recording(container, intensity_drive(ros1=container == "ros1", rpy_rad=(0.0, 0.2, 0.0), clouds=4))
    ingest([path], tmp_path / "set", RobotConfig(), IngestConfig())
    config = settings(outputs=OutputConfig(pictures_every=3))
    report = maps_of(path, tmp_path / "maps", config)
    assert report.maps == report.clouds == 4
    assert report.files == {"arrays": 4, "pictures": 2, "mcap": 4, "video": 4}
    assert report.sensor_height_m == pytest.approx(HEIGHT_M)
    assert report.height_from == "calibration"
    assert report.maps_with["solid"] == report.maps_with["pliable"] == 4
    stored = maps_of(tmp_path / "set", tmp_path / "other", config)
    mine, others = (made(tmp_path / name) for name in ("maps", "other"))
    assert mine == others
    assert len(mine) == 4 + 2 + 4
    assert replace(stored, out=report.out, seconds=report.seconds) == report


def test_the_wall_is_where_it_is_and_what_it_is(write_recording: Callable[..., Path], tmp_path: Path) -> None:
    maps_of(write_recording("mcap", intensity_drive(rpy_rad=(0.1, -0.2, 0.3))), tmp_path / "maps")
    with (tmp_path / "maps" / "maps.csv").open() as file:
        lines = list(csv.DictReader(file))
    for number, line in enumerate(lines):
        row = int((4.0 - float(line["x_m"])) / 0.1 + 50)
        classes = classes_in(tmp_path / "maps", number)
        assert (classes[row - 1 : row + 2, 54:79].max(axis=0) == CellClass.solid).all()
        assert (classes[row - 1 : row + 2, 22:46].max(axis=0) == CellClass.pliable).all()
        assert int(line["solid_cells"]) == (classes == CellClass.solid).sum()
        assert not classes[: row - 2].any()
        assert float(line["goal_rad"]) == pytest.approx(0.0, abs=1e-6)


def test_glass_is_remembered_where_odometry_places_it(write_recording: Callable[..., Path], tmp_path: Path) -> None:
    scene = scan_scene([Stand("glass", (2.0, -2.0), (2.0, 2.0)), Stand("wall", (-3.0, -3.0), (-3.0, 3.0))])
    entries = intensity_drive(seen=scene, speed_mps=0.0, clouds=4)
    report = maps_of(write_recording("mcap", entries), tmp_path / "maps")
    assert report.maps_with["transparent"] == 3  # known from the second cloud on
    rows, _ = np.nonzero(classes_in(tmp_path / "maps", 3) == CellClass.transparent)
    assert set(rows.tolist()) <= {69, 70}
    alone = intensity_drive(seen=scene, speed_mps=0.0, clouds=4, odometry=False)
    without = maps_of(write_recording("mcap", alone, name="alone"), tmp_path / "without")
    assert (without.maps_with["transparent"], without.without_odometry) == (4, 4)
    assert noted(without.notes, "odometry.no-place")


def test_jumps_of_the_odometry_are_counted_and_told(write_recording: Callable[..., Path], tmp_path: Path) -> None:
    report = maps_of(write_recording("mcap", intensity_drive(jump_s=0.5)), tmp_path / "maps")
    assert (report.odometry_jumps, report.maps) == (1, 8)
    (told,) = noted(report.notes, "odometry.jumps")
    assert "1 jumps of more than 1 m" in told


def test_clouds_beyond_the_odometry_stand_alone(write_recording: Callable[..., Path], tmp_path: Path) -> None:
    entries = intensity_drive()
    end_ns = entries[-1][2] - 400_000_000
    cut = [entry for entry in entries if entry[0] != "/odom" or entry[2] < end_ns]
    report = maps_of(write_recording("mcap", cut), tmp_path / "maps")
    assert 1 < report.without_odometry < report.maps == 8
    (told,) = noted(report.notes, "odometry.no-place")
    assert f"for {report.without_odometry} clouds" in told


def no_intensity(fields: dict[str, Any]) -> dict[str, Any]:
    return {"fields": fields["fields"][:3]}


def empty(_: dict[str, Any]) -> dict[str, Any]:
    return {"width": 0, "row_step": 0, "data": np.zeros(0, np.uint8)}


def all_nan(_: dict[str, Any]) -> dict[str, Any]:
    return cloud_fields(np.full((50, 3), np.nan), np.full(50, 9.0), np.zeros(50))


@pytest.mark.parametrize(
    ("change", "fault"),
    [
        (no_intensity, "none of the 8 clouds has intensities"),
        (empty, "none of the 8 clouds can be mapped: 8 empty"),
        (all_nan, "none of the 8 clouds can be mapped: 8 empty"),
        (with_intensity(0.0), "all intensities are 0"),
        (with_intensity(255.0), "the sensor is saturated"),
        (with_intensity(4000.0), "the largest intensity is 4000 where the sensor 'simulated' gives at most 255"),
        (with_intensity(0.9), "the largest intensity is 0.9 where full_scale is 255"),
        (with_intensity(-3.0, 200.0), "intensities are not negative"),
    ],
)
def test_a_run_that_cannot_be_mapped_is_refused_with_its_reason(
    write_recording: Callable[..., Path], tmp_path: Path, change: Callable[[dict[str, Any]], dict[str, Any]], fault: str
) -> None:
    path = write_recording("mcap", changed(intensity_drive(), slice(None), change))
    with pytest.raises(DatasetsError, match=fault) as raised:
        maps_of(path, tmp_path / "maps")
    assert raised.value.cure
    assert "/points" in str(raised.value.where)
    assert not (tmp_path / "maps").exists()
    assert not list(tmp_path.glob(".maps*"))


def test_a_later_cloud_that_is_bad_is_left_out_and_told(write_recording: Callable[..., Path], tmp_path: Path) -> None:
    entries = changed(intensity_drive(clouds=14), slice(12, 13), with_intensity(0.0))
    report = maps_of(write_recording("mcap", changed(entries, slice(13, 14), empty)), tmp_path / "maps")
    assert report.skipped == {"empty": 1, "intensities cannot be used": 1}
    assert report.maps == 12
    (told,) = noted(report.notes, "intensities.unusable")
    assert "all intensities are 0" in told


def test_clouds_that_are_usable_together_but_not_alone_give_no_maps(
    write_recording: Callable[..., Path], tmp_path: Path
) -> None:
    entries = changed(intensity_drive(), slice(0, None, 2), with_intensity(0.0))
    path = write_recording("mcap", changed(entries, slice(1, None, 2), with_intensity(255.0)))
    with pytest.raises(DatasetsError, match="none of the 8 clouds can be mapped: 8 intensities cannot be used"):
        maps_of(path, tmp_path / "maps")
    assert not (tmp_path / "maps").exists()


def test_points_that_are_none_are_counted_and_change_nothing(
    write_recording: Callable[..., Path], tmp_path: Path
) -> None:
    bad = [(np.nan, 0, 0, 9), (np.inf, 1, 1, 9), (0, 0, 0, 9), (1, 1, 1, np.inf), (0.1, 0.1, 0, 9)]
    report = maps_of(write_recording("mcap", intensity_drive(bad=bad)), tmp_path / "bad")
    assert report.points_dropped == {"not finite": 24, "no return": 8, "own body": 8}
    maps_of(write_recording("mcap", intensity_drive(), name="clean"), tmp_path / "good")
    assert hashes(tmp_path / "bad" / "arrays") == hashes(tmp_path / "good" / "arrays")


def test_a_data_set_without_intensities_is_refused_with_the_cure(
    write_recording: Callable[..., Path], tmp_path: Path
) -> None:
    path = write_recording("mcap", changed(intensity_drive(clouds=4), slice(None), no_intensity))
    ingest([path], tmp_path / "set", RobotConfig(), IngestConfig())
    with pytest.raises(DatasetsError, match="none of the 4 clouds has intensities") as raised:
        maps_of(tmp_path / "set", tmp_path / "maps")
    assert "ingest that recording again" in str(raised.value.cure)


def test_a_threshold_that_was_not_measured_on_the_sensor_is_told(
    write_recording: Callable[..., Path], tmp_path: Path
) -> None:
    path = write_recording("mcap", intensity_drive(clouds=2))
    told = "was measured on the simulated sensor, not on 'mine': fit it"
    (note,) = noted(maps_of(path, tmp_path / "a", settings(sensor="mine")).notes, "threshold.not-fitted")
    assert told in note
    fitted = replace(SMALL, obstacles=replace(SMALL.obstacles, threshold=0.4))
    for number, config in enumerate((settings(), settings(sensor="mine", map=fitted))):
        assert not noted(maps_of(path, tmp_path / f"{number}", config).notes, "threshold.not-fitted")


def test_a_mission_of_several_bags_is_one_run(write_recording: Callable[..., Path], tmp_path: Path) -> None:
    entries = intensity_drive()
    whole = maps_of(write_recording("ros1", intensity_drive(ros1=True)), tmp_path / "one")
    for name, wanted in (("lidar", True), ("rest", False)):
        part = [entry for entry in entries if (entry[0] == "/points") == wanted]
        bag = write_recording("mcap", part, name=name)
        file = bag if bag.is_file() else next(bag.glob("*.mcap"))
        (tmp_path / "mission").mkdir(exist_ok=True)
        file.rename(tmp_path / "mission" / f"{name}.mcap")
    report = maps_of(tmp_path / "mission", tmp_path / "maps", merged=True)
    assert (report.maps, report.without_odometry) == (whole.maps, 0)
    assert hashes(tmp_path / "maps" / "arrays") == hashes(tmp_path / "one" / "arrays")


def test_the_progress_adds_up(write_recording: Callable[..., Path], tmp_path: Path) -> None:
    class Sum(Silent):
        total, done_work, finished = 0, 0, ""

        def begin(self, things: int, work: int) -> None:
            self.total = things * work

        def advance(self, done: int, spared: int) -> None:
            self.done_work += done + spared
            assert self.done_work <= self.total

        def done(self, things: int, name: str) -> None:
            self.finished = f"{things} {name}"

    entries = changed(intensity_drive(clouds=14), slice(12, 13), with_intensity(0.0))
    path = write_recording("mcap", changed(entries, slice(5, 7), empty))
    progress = Sum()
    report = intensity_maps(Input(path), tmp_path / "maps", settings(), progress)
    assert progress.done_work == progress.total
    assert report.clouds == report.maps + sum(report.skipped.values())
    assert progress.finished == f"1 {report.source}"


def test_a_wrong_preset_is_told(write_recording: Callable[..., Path], tmp_path: Path) -> None:
    weak = write_recording("mcap", changed(intensity_drive(), slice(None), with_intensity(90.0, 80.0, 30.0)))
    report = maps_of(weak, tmp_path / "weak")
    threshold = MapRunConfig().map.obstacles.threshold
    (told,) = noted(report.notes, "intensities.below-threshold")
    assert f"below the threshold {threshold:g}: nothing will be solid" in told
    layers = replace(SMALL.layers, full_scale=40.0)
    strong = maps_of(weak, tmp_path / "strong", settings(map=replace(SMALL, layers=layers), sensor="mine"))
    (told,) = noted(strong.notes, "intensities.beyond-scale")
    assert "67% are above full_scale = 40: is sensor=mine the right one?" in told


def test_the_height_may_be_set(write_recording: Callable[..., Path], tmp_path: Path) -> None:
    path = write_recording("mcap", intensity_drive(footprint=False))
    report = maps_of(path, tmp_path / "unknown")
    assert (report.sensor_height_m, report.height_from) == (0.75, "setting")
    (told,) = noted(report.notes, "height.as-set")
    assert "sensor_height_m = 0.75 m, as set" in told
    known = write_recording("mcap", intensity_drive(), name="known")
    own = maps_of(known, tmp_path / "set", settings(sensor_height=SensorHeight.setting))
    assert (own.sensor_height_m, own.height_from) == (0.75, "setting")


def test_again_it_is_done_and_with_other_settings_refused(write_recording: Callable[..., Path], tmp_path: Path) -> None:
    path = write_recording("mcap", intensity_drive())
    first = maps_of(path, tmp_path / "maps")
    before = hashes(tmp_path / "maps")
    again = maps_of(path, tmp_path / "maps")
    assert replace(again, done_before=False) == replace(first, seconds=0.0)
    assert again.done_before
    assert hashes(tmp_path / "maps") == before
    with pytest.raises(DatasetsError, match="made with another sensor height"):
        maps_of(path, tmp_path / "maps", settings(sensor_height=SensorHeight.setting))
    other = write_recording("mcap", intensity_drive(speed_mps=0.4), name="other")
    with pytest.raises(DatasetsError, match="made with another input"):
        maps_of(other, tmp_path / "maps")


def test_the_same_input_gives_the_same_bytes(write_recording: Callable[..., Path], tmp_path: Path) -> None:
    path = write_recording("mcap", intensity_drive(clouds=4))
    for name in ("one", "two"):
        maps_of(path, tmp_path / name, settings(outputs=OutputConfig()))
    one, two = (made(tmp_path / name) for name in ("one", "two"))
    assert one == two


def test_every_so_many_are_written_and_all_are_mapped(write_recording: Callable[..., Path], tmp_path: Path) -> None:
    path = write_recording("mcap", intensity_drive())
    maps_of(path, tmp_path / "all")
    few = OutputConfig(arrays_every=3, pictures_every=0, mcap_every=4, video_every=0)
    report = maps_of(path, tmp_path / "few", settings(outputs=few))
    assert report.files == {"arrays": 3, "pictures": 0, "mcap": 2, "video": 0}
    some = hashes(tmp_path / "few" / "arrays")
    assert list(some) == ["000000.npz", "000003.npz", "000006.npz"]
    everything = hashes(tmp_path / "all" / "arrays")
    assert some == {name: everything[name] for name in some}
    assert not (tmp_path / "few" / "pictures").exists()
    assert "<video" not in (tmp_path / "few" / "index.html").read_text()


def test_the_page_tells_all_and_runs_nothing(write_recording: Callable[..., Path], tmp_path: Path) -> None:
    entries = [("/<b>points", *entry[1:]) if entry[0] == "/points" else entry for entry in intensity_drive()]
    robot = RobotConfig(name="<script>")
    robot.topics.lidar = ["/<b>points"]
    path = write_recording("mcap", entries)
    maps_of(path, tmp_path / "maps", settings(outputs=OutputConfig()), robot=robot)
    page = (tmp_path / "maps" / "index.html").read_text()
    assert page.count("<img") == 8
    assert "<script" not in page
    assert "<b>points" not in page
    assert '<video src="map.mp4"' in page
    assert all(name in page for name in ("transparent", "jumps of the odometry", "full_scale"))


def test_an_episode_has_to_be_chosen_where_there_are_several(
    write_recording: Callable[..., Path], tmp_path: Path
) -> None:
    paths = [write_recording("mcap", intensity_drive(speed_mps=v, clouds=4), name=f"run-{v}") for v in (0.3, 0.6)]
    ingest(paths, tmp_path / "set", RobotConfig(), IngestConfig())
    with pytest.raises(DatasetsError, match="has 2 episodes") as raised:
        maps_of(tmp_path / "set", tmp_path / "maps")
    assert "0 to 1 with --episode" in str(raised.value.cure)
    with pytest.raises(DatasetsError, match="no episode 2"):
        maps_of(tmp_path / "set", tmp_path / "maps", episode=2)
    assert "run-0.6" in maps_of(tmp_path / "set", tmp_path / "maps", episode=1).source
    with pytest.raises(DatasetsError, match="has no episodes"):
        maps_of(paths[0], tmp_path / "others", episode=1)


def test_packets_of_a_vlp16_without_odometry(recordings: Path, tmp_path: Path) -> None:
    sensor = replace(SMALL.layers, full_scale=100.0)
    config = settings(map=replace(SMALL, layers=sensor), sensor="vlp16")
    report = maps_of(recordings / "lidar" / "nebula_vlp16" / "1673400471837873222", tmp_path / "maps", config)
    assert report.maps == report.clouds == report.without_odometry == 4
    assert report.maps_with["solid"] == report.maps_with["pliable"] == 4


def test_settings_out_of_range_are_refused() -> None:
    with pytest.raises(SettingError, match="0 writes none"):
        OutputConfig(arrays_every=-1)
    with pytest.raises(SettingError, match=r"obstacles\.threshold: 7 is not below 1"):
        IntensityMapConfig(obstacles=ObstacleConfig(threshold=7.0))
    with pytest.raises(SettingError, match="largest_intensity: 100 is less than"):
        MapRunConfig(largest_intensity=100.0)


def test_figures_alone_are_written_where_nothing_else_is_asked_for(
    write_recording: Callable[..., Path], tmp_path: Path
) -> None:
    nothing = OutputConfig(arrays_every=0, pictures_every=0, mcap_every=0, video_every=0)
    report = maps_of(write_recording("mcap", intensity_drive()), tmp_path / "maps", settings(outputs=nothing))
    assert report.maps == 8
    assert sorted(path.name for path in (tmp_path / "maps").iterdir()) == ["index.html", "lineage.json", "maps.csv"]


def test_maps_without_a_point_are_told(write_recording: Callable[..., Path], tmp_path: Path) -> None:
    little = IntensityMapConfig(grid=GridConfig(cells=16, cell_m=0.1))
    path = write_recording("mcap", intensity_drive(clouds=2))
    report = maps_of(path, tmp_path / "maps", settings(map=little))
    assert noted(report.notes, "map.empty")


def test_a_planar_scan_has_no_ground_to_cut_away(write_recording: Callable[..., Path], tmp_path: Path) -> None:
    y, x = np.arange(-3.0, 3.0, 0.02), 8.0
    wall = np.stack([x + 0 * y, y, 0 * y], axis=1)
    planar = intensity_drive(clouds=3, seen=(wall, 240 + 0 * y), speed_mps=0.0)
    wide = IntensityMapConfig(grid=GridConfig(cells=200, cell_m=0.1))
    report = maps_of(write_recording("mcap", planar), tmp_path / "maps", settings(map=wide))
    assert report.maps_with["solid"] == 3
    (told,) = noted(report.notes, "lidar.level-planes")
    assert "3 clouds lie in one level plane" in told


def test_a_topic_of_the_truths_name_that_says_something_else_is_left_alone(
    write_recording: Callable[..., Path], tmp_path: Path
) -> None:
    entries = intensity_drive(clouds=2)
    entries.append(("/ground_truth/obstacles", "std_msgs/msg/Bool", entries[-1][2] + 1, {"data": True}))
    report = maps_of(write_recording("mcap", entries), tmp_path / "maps")
    assert (report.maps, report.scores) == (2, {})
