"""A disk that fills up while maps are written: one clear error, and nothing half written stays."""

from collections.abc import Callable
from pathlib import Path

import pytest
from disk_factory import SmallDisk
from intensity_drive import intensity_drive
from walking import intensity_maps

from navtool.base.errors import OutputError
from navtool.methods.along.source import Input
from navtool.methods.intensity_map.config import MapRunConfig, OutputConfig

OUTPUTS = ("arrays_every", "pictures_every", "mcap_every", "video_every")


@pytest.mark.parametrize("output", OUTPUTS)
@pytest.mark.parametrize("free_bytes", [0, 40_000])
def test_a_full_disk_is_told(
    write_recording: Callable[..., Path], small_disk: Callable[[int], SmallDisk], output: str, free_bytes: int
) -> None:
    path = write_recording("mcap", intensity_drive(clouds=6))
    disk = small_disk(1)
    spare = disk.place / "spare"
    spare.write_bytes(bytes(free_bytes))
    disk.fill()
    spare.unlink()
    config = MapRunConfig(outputs=OutputConfig(**{**dict.fromkeys(OUTPUTS, 0), output: 1}))
    with pytest.raises(OutputError, match=r"cannot be written \(.*space"):
        intensity_maps(Input(path), disk.place / "maps", config)
    assert [entry.name for entry in disk.place.iterdir()] == ["filler"]
