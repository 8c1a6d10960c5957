"""What a folder is, for inspect and ingest alike: split_without_metadata, file_compression, odd descriptions."""

import shutil
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest
import zstandard
from drive_factory import START_NS, drive
from ingesting import ingested
from noted import noted

from navtool.base.errors import DatasetsError
from navtool.datasets.ingest.natural import expand
from navtool.datasets.inspect.inspection import inspect_recording
from navtool.datasets.recording import open_recording
from navtool.datasets.recording.part_names import without_copies

STREAMS = ("odometry", "lidar", "tf")
type Make = Callable[..., Any]


def parts_of_a_drive(
    writer: Make, folder: Path, container: str, count: int, name: str = "run", *, gap_s: float = 0.0
) -> Path:
    """A folder with the parts of one drive, tf_static in the first one alone, and no description."""
    entries = drive(count / 2, streams=STREAMS)
    out, made_in = folder / name, folder / f"{name}-made"
    out.mkdir(parents=True)
    made_in.mkdir()
    for part in range(count):
        inside = [
            (topic, kind, record_ns + round(part * gap_s * 1e9), fields)
            for topic, kind, record_ns, fields in entries
            if part * 500_000_000 <= record_ns - START_NS < (part + 1) * 500_000_000
        ]
        made = writer(made_in, container, inside, f"made-{name}-{part}")
        file = made if made.is_file() else next(x for x in made.iterdir() if x.suffix in (".db3", ".mcap"))
        shutil.move(file, out / f"{name}_{part}{file.suffix}")
    shutil.rmtree(made_in)
    return out


def packed(file: Path, *, keep: bool = False, cut: int | None = None) -> Path:
    out = file.with_name(f"{file.name}.zstd")
    out.write_bytes(zstandard.ZstdCompressor().compress(file.read_bytes())[:cut])
    if not keep:
        file.unlink()
    return out


def assert_one_recording(folder: Path, out: Path, rows: int, *, given: Path | None = None) -> list[Any]:
    """Inspect and ingest take the folder for one recording of the whole drive; its notes."""
    seen = inspect_recording(folder)
    report = ingested([given or folder], out)
    assert not report.quarantined, report.quarantined
    (episode,) = report.episodes
    assert episode.rows == rows
    assert seen.messages > rows
    (table,) = out.glob("data/*/*.parquet")
    assert np.array(pq.read_table(table).column("valid.lidar").to_pylist()).mean() > 0.9
    assert not noted(episode.notes, "sensor.no-pose"), "the transforms of the first part hold for the others"
    return episode.notes


@pytest.mark.parametrize("container", ["mcap", "db3", "ros1"])
def test_split_without_metadata(container: str, recording_writer: Make, tmp_path: Path) -> None:
    folder = parts_of_a_drive(recording_writer, tmp_path / "drives", container, 12)
    notes = assert_one_recording(folder, tmp_path / "out", 60, given=tmp_path / "drives")
    (said,) = noted(notes, "recording.parts")
    assert said.startswith("12 numbered files")
    assert said.index("run_9") < said.index("run_10")


def test_several_split_recordings_in_a_folder_are_told_apart(recording_writer: Make, tmp_path: Path) -> None:
    for name in ("a", "b"):
        parts_of_a_drive(recording_writer, tmp_path, "mcap", 3, name)
    folder = tmp_path / "both"
    folder.mkdir()
    for file in [*(tmp_path / "a").iterdir(), *(tmp_path / "b").iterdir()]:
        shutil.move(file, folder / file.name)
    assert [path.name for path in expand([folder])] == ["a_*.mcap", "b_*.mcap"]
    report = ingested([folder], tmp_path / "out")
    assert [episode.rows for episode in report.episodes] == [15, 15]
    assert ingested([folder], tmp_path / "out").skipped == [episode.source for episode in report.episodes]
    with pytest.raises(DatasetsError, match=r"holds 2 recordings, not one: a_\*\.mcap, b_\*\.mcap"):
        inspect_recording(folder)
    assert inspect_recording(folder / "a_*.mcap").messages > 15


@pytest.mark.parametrize(
    ("names", "gap_s"),
    [(("run_0", "run_1"), 60.0), (("run_0", "run_2"), 0.0), (("run_000", "run_001"), 0.0), (("run-0", "run-1"), 0.0)],
    ids=["a minute apart", "not one behind the other", "numbered by hand", "named another way"],
)
def test_runs_are_not_parts(names: Sequence[str], gap_s: float, recording_writer: Make, tmp_path: Path) -> None:
    parts = parts_of_a_drive(recording_writer, tmp_path / "made", "mcap", 2, gap_s=gap_s)
    folder = tmp_path / "runs"
    folder.mkdir()
    for part, name in zip(sorted(parts.iterdir()), names, strict=True):
        shutil.move(part, folder / f"{name}.mcap")
    assert len(expand([folder])) == 2
    with pytest.raises(DatasetsError, match="holds 2 recordings, not one"):
        inspect_recording(folder)


@pytest.mark.parametrize("kind", ["killed", "left over", "left over and torn", "torn beside the whole packed one"])
def test_file_compression(kind: str, recording_writer: Make, tmp_path: Path) -> None:
    folder = parts_of_a_drive(recording_writer, tmp_path, "db3", 3)
    first, second, last = sorted(folder.iterdir())
    codes = []
    if kind == "killed":
        packed(first)
        packed(second)
    elif kind == "left over":
        packed(last, keep=True)
        codes = ["recording.copies"]
    elif kind == "left over and torn":
        packed(last, keep=True, cut=-100)
        codes = ["recording.copies"]
    else:
        packed(last, keep=True)
        last.write_bytes(last.read_bytes()[:5000])
        codes = ["recording.copies"]
    notes = assert_one_recording(folder, tmp_path / "out", 15)
    assert [note.code for note in notes if note.code == "recording.copies"] == codes


def described(folder: Path, names: Sequence[str]) -> Path:
    text = f"rosbag2_bagfile_information: {{relative_file_paths: [{', '.join(names)}]}}"
    (folder / "metadata.yaml").write_text(text)
    return folder


@pytest.mark.parametrize("text", ["", "}{", "a: 1", "rosbag2_bagfile_information: 3", "- 1\n- 2", "\0", "images: []"])
def test_an_empty_or_foreign_description_is_a_note(text: str, recording_writer: Make, tmp_path: Path) -> None:
    folder = parts_of_a_drive(recording_writer, tmp_path, "mcap", 2)
    (folder / "metadata.yaml").write_text(text)
    (said,) = noted(assert_one_recording(folder, tmp_path / "out", 10), "recording.description")
    assert said.startswith("metadata.yaml ")


@pytest.mark.parametrize(
    ("names", "rows", "said"),
    [
        (["run_0.mcap", "run_1.mcap"], 15, "does not list run_2.mcap, which is read all the same"),
        (["run_0.mcap", "run_1.mcap", "run_2.mcap", "run_3.mcap"], 15, "lists run_3.mcap, which is not there"),
        (["old_0.mcap"], 15, "lists old_0.mcap, which is not there"),
        ([], 15, "lists no files"),
        (["run_0.mcap.zstd", "run_1.mcap.zstd", "run_2.mcap.zstd"], 15, "packed another way"),
    ],
)
def test_an_outdated_description_is_a_note(
    names: list[str], rows: int, said: str, recording_writer: Make, tmp_path: Path
) -> None:
    folder = described(parts_of_a_drive(recording_writer, tmp_path, "mcap", 3), names)
    assert any(
        said in note for note in noted(assert_one_recording(folder, tmp_path / "out", rows), "recording.description")
    )


def test_a_file_that_is_no_part_is_named_and_left(recording_writer: Make, tmp_path: Path) -> None:
    folder = parts_of_a_drive(recording_writer, tmp_path, "mcap", 2)
    shutil.copy(folder / "run_0.mcap", folder / "calibration.mcap")
    described(folder, ["run_0.mcap", "run_1.mcap"])
    (said,) = noted(assert_one_recording(folder, tmp_path / "out", 10), "recording.description")
    assert "does not list calibration.mcap, which is not read" in said


def test_a_part_that_cannot_be_read_is_left_out_and_named(recording_writer: Make, tmp_path: Path) -> None:
    folder = parts_of_a_drive(recording_writer, tmp_path, "mcap", 3)
    (folder / "run_1.mcap").write_bytes(b"")
    with open_recording(folder) as recording:
        assert recording.faults == ("run_1.mcap is left out: the file is empty",)
    report = ingested([folder], tmp_path / "out")
    assert any("run_1.mcap is left out" in note for note in noted(report.episodes[0].notes, "recording.recovered"))


@pytest.mark.parametrize("text", ["[" * 100_000, "rosbag2_bagfile_information: {relative_file_paths: run_0.mcap}"])
def test_a_description_that_no_recorder_wrote_is_a_note(text: str, recording_writer: Make, tmp_path: Path) -> None:
    folder = parts_of_a_drive(recording_writer, tmp_path, "mcap", 2)
    (folder / "metadata.yaml").write_text(text)
    (said,) = noted(assert_one_recording(folder, tmp_path / "out", 10), "recording.description")
    assert said.startswith("metadata.yaml describes no recording")


def test_the_description_of_another_recording_hides_none(recording_writer: Make, tmp_path: Path) -> None:
    folder = tmp_path / "recordings"
    beside, below = folder / "beside", folder / "below"
    for name, path in (("a", beside), ("b", beside), ("c", below / "deep")):
        made = parts_of_a_drive(recording_writer, tmp_path, "mcap", 1, name)
        path.mkdir(parents=True, exist_ok=True)
        shutil.move(made / f"{name}_0.mcap", path / f"{name}.mcap")
    for path in (beside, below):
        described(path, ["another_0.mcap"])
    found = [path.relative_to(folder).as_posix() for path in expand([folder])]
    assert found == ["below", "below/deep/c.mcap", "beside/a.mcap", "beside/b.mcap"]
    with pytest.raises(DatasetsError, match=r"holds 2 recordings, not one: a\.mcap, b\.mcap"):
        inspect_recording(beside)
    with pytest.raises(DatasetsError, match="1 of the 1 files it lists are missing"):
        inspect_recording(below)


@pytest.mark.parametrize(
    ("kept", "read", "why"),
    [(1.0, "run.db3", "holds as many bytes"), (0.5, "run.db3", "holds fewer bytes"), (2.0, "run.db3.zstd", "not all")],
)
def test_of_copies_that_do_not_say_their_size_the_longer_one_is_read(
    kept: float, read: str, why: str, tmp_path: Path
) -> None:
    content = bytes(100_000)
    (tmp_path / "run.db3").write_bytes(content)
    frame = zstandard.ZstdCompressor().compressobj()
    (tmp_path / "run.db3.zstd").write_bytes(frame.compress((content * 2)[: int(kept * len(content))]) + frame.flush())
    (chosen,) = without_copies(tmp_path.iterdir())
    assert (chosen.file.name, why in chosen.notes[0].text) == (read, True), chosen.notes
