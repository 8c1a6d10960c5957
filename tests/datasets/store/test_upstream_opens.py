"""Whatever ingest writes, of recordings in any container and of those of many labs, upstream opens and reads."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.ingest.ingest import ingest
from navtool.datasets.ingest.natural import expand
from navtool.datasets.robot.config import RobotConfig


@pytest.mark.slow
def test_a_drive_in_any_container(
    assert_upstream_opens: Callable[[Path], None],
    containers: tuple[str, ...],
    write_recording: Callable[..., Path],
    drive_entries: Callable[..., Any],
    tmp_path: Path,
) -> None:
    for container in containers:
        ros1 = container.startswith("ros1") or container == "mcap_ros1"
        path = write_recording(container, drive_entries(2.0, ros1=ros1), container)
        out = tmp_path / "out" / container
        report = ingest([path], out, RobotConfig(), IngestConfig())
        assert not report.quarantined, container
        assert_upstream_opens(out)


@pytest.mark.slow
@pytest.mark.recordings
def test_the_recordings_of_many_labs(
    assert_upstream_opens: Callable[[Path], None], recordings: Path, tmp_path: Path
) -> None:
    opened, reasons = [], {}
    for number, path in enumerate(expand([recordings / "bags", recordings / "lidar" / "nebula_vlp16"])):
        out = tmp_path / f"out-{number}"
        report = ingest([path], out, RobotConfig(), IngestConfig())
        if report.episodes:
            assert_upstream_opens(out)
            opened.append(path.name)
        else:
            assert not out.exists()
            reasons[path.name] = report.quarantined[0].reason
    assert len(opened) > 5
    assert all(" (" in reason for reason in reasons.values()), "every reason has its cure"
