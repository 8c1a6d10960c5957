"""Recordings fetched from elsewhere: an in-memory store and a real web server."""

import socket
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import aiohttp
import fsspec
import pytest
from counted import Counted

from navtool.base.errors import DatasetsError
from navtool.datasets.recording import open_recording
from navtool.datasets.recording.remote import local_paths

type Entry = tuple[str, str, int, dict[str, Any]]
IMU: list[Entry] = [("/imu", "sensor_msgs/msg/Imu", 10**9 + k * 10**7, {}) for k in range(9)]


@pytest.fixture
def store() -> Iterator[Any]:
    memory = fsspec.filesystem("memory")
    yield memory
    memory.rm("/", recursive=True)


def test_a_file_of_a_web_server(
    server: tuple[str, Path], recording_writer: Callable[..., Path], tmp_path: Path
) -> None:
    url, folder = server
    written = recording_writer(folder, "mcap_lz4", IMU, "run-1")
    progress = Counted()
    (path,) = local_paths([f"{url}/run-1.mcap"], tmp_path / "cache", progress)
    assert path.name == "run-1.mcap"
    assert path.read_bytes() == written.read_bytes()
    assert progress.begun == (1, written.stat().st_size)
    assert (progress.worked, progress.spared) == (written.stat().st_size, 0)
    assert [things for things, _ in progress.finished] == [1]
    with open_recording(path) as recording:
        assert recording.message_count == 9
    again = Counted()
    assert local_paths([f"{url}/run-1.mcap"], tmp_path / "cache", again) == [path]
    assert again.begun is None
    with pytest.raises(DatasetsError, match="there is nothing at this address"):
        local_paths([f"{url}/absent.mcap"], tmp_path / "cache")


@pytest.mark.parametrize("name", ["run.mcap", "runs/"])
def test_why_a_server_cannot_be_read(server: tuple[str, Path], tmp_path: Path, name: str) -> None:
    url, _ = server
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))  # bound and not listened to: nobody else gets the port
        with pytest.raises(DatasetsError, match="the connection was refused"):
            local_paths([f"http://127.0.0.1:{taken.getsockname()[1]}/{name}"], tmp_path / "cache")
    with pytest.raises(DatasetsError, match="there is no such host"):
        local_paths([f"http://nowhere.invalid/{name}"], tmp_path / "cache")
    for status, said in ((403, "access was denied"), (401, "access was denied"), (503, "status 503")):
        with pytest.raises(DatasetsError, match=said):
            local_paths([f"{url}/status-{status}/{name}"], tmp_path / "cache")
    assert not (tmp_path / "cache").exists()


def test_a_server_that_is_silent(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(fsspec.config.conf, "http", {"client_kwargs": {"timeout": aiohttp.ClientTimeout(total=0.3)}})
    fsspec.filesystem("http").clear_instance_cache()
    with socket.create_server(("127.0.0.1", 0)) as silent:
        url = f"http://127.0.0.1:{silent.getsockname()[1]}/run.mcap"
        with pytest.raises(DatasetsError, match="did not answer in time"):
            local_paths([url], tmp_path / "cache")
    fsspec.filesystem("http").clear_instance_cache()


def test_a_folder_and_a_pattern_of_a_store(store: Any, recording_writer: Callable[..., Path], tmp_path: Path) -> None:
    for place in ("field", "forest"):
        for number in range(2):
            written = recording_writer(tmp_path, "mcap_lz4", IMU, f"{place}-{number}")
            store.pipe(f"/runs/{place}/run-{number}.mcap", written.read_bytes())
    store.pipe("/runs/forest/notes.txt", b"nothing")
    (folder,) = local_paths(["memory://runs"], tmp_path / "cache")
    names = sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file())
    assert names == ["field/run-0.mcap", "field/run-1.mcap", "forest/run-0.mcap", "forest/run-1.mcap"]
    (some,) = local_paths(["memory://runs/forest/*.mcap"], tmp_path / "cache")
    assert sorted(path.name for path in some.iterdir()) == ["run-0.mcap", "run-1.mcap"]
    with pytest.raises(DatasetsError, match="there is nothing at this address"):
        local_paths(["memory://empty"], tmp_path / "cache")
    with pytest.raises(DatasetsError, match="no recording there"):
        local_paths(["memory://runs/forest/*.bag"], tmp_path / "cache")


def test_local_patterns_and_unknown_protocols(recording_writer: Callable[..., Path], tmp_path: Path) -> None:
    written = [recording_writer(tmp_path, "mcap_lz4", IMU, f"run-{n}") for n in range(3)]
    assert local_paths([str(tmp_path / "run-*.mcap")], tmp_path / "cache") == written
    assert local_paths([str(tmp_path / "absent.bag")], tmp_path / "cache") == [tmp_path / "absent.bag"]
    with pytest.raises(DatasetsError, match="matches the pattern"):
        local_paths([str(tmp_path / "no-*.bag")], tmp_path / "cache")
    with pytest.raises(DatasetsError, match="nosuch"):
        local_paths(["nosuch://bucket/run.bag"], tmp_path / "cache")
