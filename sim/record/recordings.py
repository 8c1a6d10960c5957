"""The folder of a simulation's recordings, with what each was made from."""

import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from navtool.base.errors import DatasetsError
from navtool.base.files import read_json, write_json
from navtool.base.from_plain import from_plain
from navtool.base.lineage import config_hash
from navtool.base.output_folder import OutputFolder
from navtool.base.plain import flatten, plain, plain_fields
from navtool.base.setting_error import SettingError
from navtool.sim.record.config import SimulationConfig
from navtool.sim.record.episode import Episode

LINEAGE = "simulation.json"
"""Name of the file that says what each recording was made from."""
_SCHEMA = 1
_CURE = "choose another folder with --out, or remove this one"


class Recordings:
    """A locked folder of recordings of one configuration and seed."""

    def __init__(self, folder: OutputFolder, config: SimulationConfig, seed: int) -> None:
        self.root, self.staging = folder.root, folder.root / ".unfinished"
        self.episodes: dict[int, Episode] = {}
        """By number; those whose recording is there."""
        self._folder = folder
        self._said = {"schema": _SCHEMA, "seed": seed, "config": plain(config), "config_sha256": config_hash(config)}
        self._load()

    def keep(self, episode: Episode) -> None:
        """Note a recording that is there."""
        self.episodes[episode.plan.number] = episode
        self.write()

    def write(self) -> None:
        """Write what each recording was made from; equal recordings give equal bytes.

        Raises:
            OutputError: It cannot be written.
        """
        made = [self.episodes[number] for number in sorted(self.episodes)]
        listed = [
            {key: value for key, value in plain_fields(episode).items() if key != "peak_rss_mib"} for episode in made
        ]
        write_json(self.root / LINEAGE, {**self._said, "episodes": listed})

    def _load(self) -> None:
        file = self.root / LINEAGE
        if not file.exists():
            return
        found = read_json(file, _CURE)
        if found.get("schema") != _SCHEMA:
            raise DatasetsError(f"is of schema {found.get('schema')!r}, not {_SCHEMA}", where=file, cure=_CURE)
        self._folder.refuse_differing(_identity(found))
        listed = found.get("episodes")
        for entry in listed if isinstance(listed, list) else []:
            try:
                episode = from_plain(Episode, {**entry, "peak_rss_mib": 0.0}, where=file)
            except SettingError as error:
                raise DatasetsError(f"is damaged ({error.what})", where=file, cure=_CURE) from error
            if self._is_there(episode):
                self.episodes[episode.plan.number] = episode

    def _is_there(self, episode: Episode) -> bool:
        path = self.root / episode.plan.path
        if path.is_dir():
            return sum(part.stat().st_size for part in path.iterdir()) == episode.size_bytes
        return path.is_file() and path.stat().st_size == episode.size_bytes


def recordings_folder(root: Path, config: SimulationConfig | None = None, seed: int = 0) -> OutputFolder:
    """The folder of recordings; of a configuration and seed, to write into it."""
    identity = {} if config is None else _identity({"seed": seed, "config": plain(config)})
    return OutputFolder(root, record=LINEAGE, identity=identity)


@contextmanager
def open_recordings(root: Path, config: SimulationConfig, seed: int) -> Iterator[Recordings]:
    """The recordings of a configuration and seed, in a folder that is made where it is not there.

    What an earlier run left unfinished is removed; so is a folder that was made in vain.

    Raises:
        DatasetsError: Another process writes to it, or it holds something else or recordings of other settings.
        OutputError: It cannot be written to.
    """
    folder = recordings_folder(root, config, seed)
    with folder.held(lambda: _is_empty(folder)):
        recordings = Recordings(folder, config, seed)
        shutil.rmtree(recordings.staging, ignore_errors=True)
        recordings.write()
        try:
            yield recordings
        finally:
            shutil.rmtree(recordings.staging, ignore_errors=True)


def _is_empty(folder: OutputFolder) -> bool:
    """Whether there is no recording, neither one that is listed nor one that is not yet."""
    try:
        listed = read_json(folder.root / LINEAGE, _CURE).get("episodes")
    except DatasetsError:
        return False
    return not listed and {path.name for path in folder.root.iterdir()} <= {LINEAGE, folder.lock}


def _identity(said: Mapping[str, object]) -> dict[str, object]:
    return {"seed": said.get("seed"), **flatten(said.get("config"))}
