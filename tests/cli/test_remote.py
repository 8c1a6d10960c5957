"""Recordings named by URL on the command line, fetched from a server on the loopback."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The user's cache folder, below which recordings are kept."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path / "cache" / "navtool" / "recordings"


def test_inspect_and_ingest_take_the_same_url_and_fetch_it_once(
    navtool_here: Callable[..., Any],
    server: tuple[str, Path],
    cache: Path,
    recording_writer: Callable[..., Path],
    drive_entries: Callable[..., Any],
    tmp_path: Path,
) -> None:
    url, folder = server
    served = recording_writer(folder, "mcap_unchunked", drive_entries(), "run-1")
    page = tmp_path / "run.html"
    found = json.loads(navtool_here("inspect", f"{url}/run-1.mcap", "--json", "--report", page).out)
    local = json.loads(navtool_here("inspect", served, "--json").out)
    (kept,) = (path for path in cache.rglob("*") if path.is_file())
    assert found | {"path": ""} == local | {"path": ""}
    assert page.is_file()
    served.write_bytes(bytes(kept.stat().st_size))
    assert navtool_here("ingest", f"{url}/run-1.mcap", "--out", tmp_path / "dataset").code == 0, (
        "of what was fetched before"
    )


def test_inspect_takes_the_url_of_a_folder(
    navtool_here: Callable[..., Any],
    server: tuple[str, Path],
    cache: Path,
    recording_writer: Callable[..., Path],
    drive_entries: Callable[..., Any],
) -> None:
    url, folder = server
    served = recording_writer(folder, "db3", drive_entries(), "run-1")
    found = json.loads(navtool_here("inspect", f"{url}/run-1/", "--json").out)
    assert found["messages"] == json.loads(navtool_here("inspect", served, "--json").out)["messages"]
    assert {path.name for path in cache.glob("*/*")} == {"run-1"}


@pytest.mark.parametrize(
    ("address", "said"), [("absent.mcap", "nothing at this address"), ("status-403/run.mcap", "access was denied")]
)
def test_inspect_and_ingest_say_the_same_of_a_url_that_cannot_be_read(
    navtool_here: Callable[..., Any], server: tuple[str, Path], cache: Path, tmp_path: Path, address: str, said: str
) -> None:
    url = f"{server[0]}/{address}"
    inspected, ingested = navtool_here("inspect", url), navtool_here("ingest", url, "--out", tmp_path / "dataset")
    assert (inspected.code, inspected.err) == (ingested.code, ingested.err)
    assert inspected.code == 1
    assert said in inspected.err
    assert url in inspected.err
    assert not cache.exists()
    assert not (tmp_path / "dataset").exists()
