"""The folder of a simulation's recordings, with what each was made from."""

import fcntl
import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from navtool.base.errors import DatasetsError
from navtool.base.files import read_json, write_json
from navtool.base.from_plain import from_plain
from navtool.base.lineage import config_hash, plain
from navtool.sim.errors import SimError
from navtool.sim.record.config import SimulationConfig
from navtool.sim.record.episode import Episode

LINEAGE = "simulation.json"
"""Name of the file that says what each recording was made from."""
_SCHEMA = 1
_STAGING, _LOCK = ".unfinished", ".lock"
_CURE = "choose another folder with --out, or remove this one"


class OutputFolder:
    """A locked folder of recordings of one configuration and seed."""

    def __init__(self, root: Path, config: SimulationConfig, seed: int) -> None:
        self.root, self.staging = root, root / _STAGING
        self.episodes: dict[int, Episode] = {}
        """By number; those whose recording is there."""
        self._said = {"schema": _SCHEMA, "seed": seed, "config": plain(config), "config_sha256": config_hash(config)}
        self._load()

    def keep(self, episode: Episode) -> None:
        """Note a recording that is there."""
        self.episodes[episode.plan.number] = episode
        self.write()

    def write(self) -> None:
        """Write what each recording was made from; equal recordings give equal bytes.

        Raises:
            SimError: It cannot be written.
        """
        made = [self.episodes[number] for number in sorted(self.episodes)]
        listed = [{key: value for key, value in _plain(episode).items() if key != "peak_rss_mib"} for episode in made]
        try:
            write_json(self.root / LINEAGE, {**self._said, "episodes": listed})
        except DatasetsError as error:
            raise SimError(error.what, where=error.where, cure=error.cure) from error

    def _load(self) -> None:
        file = self.root / LINEAGE
        if not file.exists():
            return
        try:
            found = read_json(file, _CURE)
            self._refuse_others(found)
            listed = found.get("episodes")
            for entry in listed if isinstance(listed, list) else []:
                episode = from_plain(Episode, {**entry, "peak_rss_mib": 0.0}, where=file)
                if self._is_there(episode):
                    self.episodes[episode.plan.number] = episode
        except DatasetsError as error:
            raise SimError(error.what, where=error.where, cure=_CURE) from error

    def _refuse_others(self, found: Mapping[str, object]) -> None:
        """Refuse to go on with recordings of another configuration, and say what differs."""
        if found.get("schema") != _SCHEMA:
            raise SimError(
                f"is of schema {found.get('schema')!r}, not {_SCHEMA}", where=self.root / LINEAGE, cure=_CURE
            )
        then, now = ({"seed": said.get("seed"), **_flat(said.get("config"))} for said in (found, self._said))
        differ = [key for key in {**then, **now} if then.get(key) != now.get(key)]
        if differ:
            said = "; ".join(f"{key} was {then.get(key)}, now {now.get(key)}" for key in sorted(differ)[:4])
            more = f" and {len(differ) - 4} more" if len(differ) > 4 else ""
            what = f"its recordings were made with other settings ({said}{more})"
            raise SimError(what, where=self.root, cure=f"give the same settings again, or {_CURE}")

    def _is_there(self, episode: Episode) -> bool:
        path = self.root / episode.plan.path
        if path.is_dir():
            return sum(part.stat().st_size for part in path.iterdir()) == episode.size_bytes
        return path.is_file() and path.stat().st_size == episode.size_bytes


def refuse_other_folder(root: Path) -> None:
    """Do nothing where recordings are or may be made.

    Raises:
        SimError: It is a file, or a folder that holds something else.
    """
    if root.exists() and not root.is_dir():
        raise SimError("is a file", where=root, cure="name a folder with --out")
    if root.is_dir() and not (root / LINEAGE).exists():
        strangers = sorted(path.name for path in root.iterdir() if path.name not in {_STAGING, _LOCK})
        if strangers:
            what = f"the folder holds something else ({', '.join(strangers[:3])})"
            raise SimError(what, where=root, cure="choose an empty or a new folder with --out")


@contextmanager
def open_output(root: Path, config: SimulationConfig, seed: int) -> Iterator[OutputFolder]:
    """The folder for a configuration and seed, made where it is not there, while nobody else writes to it.

    What an earlier run left unfinished is removed; so is a folder that was made in vain.

    Raises:
        SimError: Another process writes to it, it holds something else or recordings of other settings, or cannot be
            written to.
    """
    refuse_other_folder(root)
    created = not root.exists()
    try:
        root.mkdir(parents=True, exist_ok=True)
        lock = (root / _LOCK).open("w")
    except OSError as error:
        raise SimError(f"cannot be written ({error.strerror})", where=root, cure="check its rights") from error
    with lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            cure = "wait until it is done, or choose another folder with --out"
            raise SimError("another process is writing to it", where=root, cure=cure) from error
        try:
            folder = OutputFolder(root, config, seed)
            shutil.rmtree(folder.staging, ignore_errors=True)
            folder.write()
            yield folder
        finally:
            shutil.rmtree(root / _STAGING, ignore_errors=True)
            if created and {path.name for path in root.iterdir()} <= {LINEAGE, _LOCK} and not _has_episodes(root):
                shutil.rmtree(root)


def _has_episodes(root: Path) -> bool:
    try:
        return bool(read_json(root / LINEAGE, _CURE).get("episodes"))
    except DatasetsError:
        return False


def _plain(episode: Episode) -> dict[str, object]:
    found = plain(episode)
    return {str(key): value for key, value in found.items()} if isinstance(found, dict) else {}


def _flat(value: object, prefix: str = "") -> dict[str, object]:
    """Nested settings as key.key: value."""
    if not isinstance(value, dict):
        return {prefix: value}
    found: dict[str, object] = {}
    for key, entry in value.items():
        found |= _flat(entry, f"{prefix}.{key}" if prefix else str(key))
    return found
