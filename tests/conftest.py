"""Shared fixtures: where the real recordings lie, and run-time checks of array shapes."""

import os
from pathlib import Path

import pytest
from hypothesis import settings
from shape_checks import check_while_running

pytest_plugins = (
    "recording_factory",
    "drive_factory",
    "robot_factory",
    "composed_factory",
    "disk_factory",
    "upstream_factory",
    "web_factory",
)

check_while_running(["navtool.pipeline", "navtool.datasets", "navtool.sim", "navtool.methods"])

# The same code passes or fails the same way each time; NAVTOOL_EXPLORE=1 looks for new counterexamples.
settings.register_profile("repeatable", derandomize=True)
if "NAVTOOL_EXPLORE" not in os.environ:
    settings.load_profile("repeatable")


@pytest.fixture(scope="session")
def recordings() -> Path:
    """The folder of real recordings; tests that need it skip where it is absent, and say so."""
    default = Path(__file__).resolve().parents[2] / "shared" / "data"
    folder = Path(os.environ.get("NAVTOOL_DATA", default))
    if not (folder / "SOURCES.md").is_file():
        pytest.skip(f"no real recordings at {folder}; set NAVTOOL_DATA to their folder")
    return folder
