"""The data set as a store of episodes: one writer at a time, an episode is in it whole or not at all."""

import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pyarrow.parquet as pq

from navtool.base.errors import OutputError
from navtool.base.files import move, read_json, write_bytes, write_json
from navtool.base.output_folder import OutputFolder
from navtool.datasets.store.description import Description, read_description
from navtool.datasets.store.journal import commit, finish, journal_path
from navtool.datasets.store.journal import staged as replacement
from navtool.datasets.store.layout import Layout
from navtool.datasets.store.metadata import episode_entry, info_of, task_table
from navtool.datasets.store.replace import replace_episode
from navtool.datasets.store.schema import features_of, video_keys
from navtool.datasets.store.staged_episode import EpisodeFolder, Numbering
from navtool.datasets.store.stats import Stats, aggregate

_REBUILD = "ingest the recordings again into another folder"


def data_set_folder(root: Path) -> OutputFolder:
    """The folder of a data set, as one that is written to."""
    layout = Layout(root)
    return OutputFolder(root, record=layout.beside.name, lock=layout.lock.relative_to(root).as_posix())


@contextmanager
def open_store(root: Path) -> Iterator["Store"]:
    """Lock a data set for writing, an existing or a new one, and clear away what an interrupted writer left.

    The kernel releases the lock with the process, however it ends.

    Raises:
        DatasetsError: If another process writes to it, or the folder holds something else.
    """
    layout = Layout(root)
    with data_set_folder(root).held(lambda: not layout.info.exists() and not journal_path(root).exists()):
        finish(root)
        store = Store(layout)
        store.clear()
        try:
            yield store
        finally:
            store.clear()


class Store:
    """A locked data set."""

    def __init__(self, layout: Layout) -> None:
        self.layout = layout
        self.description: Description | None = None
        self.episodes = 0
        self.rows = 0
        self._stats: dict[str, Stats] = {}
        self._provenance: list[dict[str, Any]] = []
        if layout.description.is_file():
            self.description = read_description(layout.root)
            info = read_json(layout.info, _REBUILD)
            self.episodes, self.rows = int(str(info["total_episodes"])), int(str(info["total_frames"]))
            stats: dict[str, Any] = read_json(layout.stats, _REBUILD)
            self._stats = stats
            files = (layout.episode(number) / "provenance.json" for number in range(self.episodes))
            self._provenance = [read_json(file, _REBUILD) for file in files]

    def provenance(self) -> list[dict[str, Any]]:
        """What each episode was made from."""
        return list(self._provenance)

    def episode_from(self, source: str, sha256: str, recording_start_ns: int) -> int | None:
        """The episode that the same recording became before; None where there is none.

        The same recording is one of the same bytes, or one of the same name that began at the same moment: it was still
        being written or copied then. A name alone says little: runs of many days are called alike.
        """
        for number, entry in enumerate(self._provenance):
            named = (entry["source"], entry["recording_start_ns"]) == (source, recording_start_ns)
            if named or entry["sha256"] == sha256:
                return number
        return None

    def set_place(self, sha256: str, place: str) -> bool:
        """Say where a recording was made; whether that is news.

        Raises:
            OutputError: It cannot be written.
        """
        for number, entry in enumerate(self._provenance):
            if entry["sha256"] == sha256 and entry["place"] != place:
                self._provenance[number] = entry | {"place": place}
                self._write_provenance(number)
                return True
        return False

    def _write_provenance(self, episode: int) -> None:
        write_json(self.layout.episode(episode) / "provenance.json", self._provenance[episode])

    def numbering(self, episode: int | None) -> Numbering:
        """The place of the next episode, or that of one that is to be replaced."""
        if episode is None:
            return Numbering(self.episodes, self.rows)
        entry = pq.read_table(self.layout.episode_meta(episode), columns=["dataset_from_index"])
        return Numbering(episode, int(entry.column(0)[0].as_py()))

    def clear(self) -> None:
        """Remove staged files, and files of episodes that never became part of the data set.

        While a journal is there, the episode that it counts is one: only whoever finishes the step knows how many.
        """
        shutil.rmtree(self.layout.staging, ignore_errors=True)
        if journal_path(self.layout.root).exists():
            return
        number = self.episodes
        while self._remove(number):
            number += 1

    def _remove(self, episode: int) -> bool:
        layout = self.layout
        files = (layout.data(episode), *layout.videos(episode), layout.episode_meta(episode))
        folder = layout.episode(episode)
        there = folder.exists() or any(file.exists() for file in files)
        for file in files:
            file.unlink(missing_ok=True)
        if folder.exists():
            shutil.rmtree(folder)
        return there

    def replace(self, staged: EpisodeFolder, provenance: Mapping[str, object]) -> None:
        """Put a staged episode in the place of the one of its number, in one journalled step.

        Episodes behind it keep their rows; where these count on from another number of rows, their counters are
        written again. The labels do not hold any more and are taken away.

        Raises:
            OutputError: If a file cannot be written; the data set is then as it was.
        """
        if self.description is None:
            raise ValueError("a data set without a description has no episodes")
        write_json(staged.beside / "provenance.json", provenance)
        self._stats, self.rows = replace_episode(self.layout, staged, self.description, self.episodes)
        self._provenance[staged.numbering.episode_index] = dict(provenance)

    def commit(self, staged: EpisodeFolder, description: Description, provenance: Mapping[str, object]) -> None:
        """Make a staged episode the data set's next one. Until ``info.json`` counts it, it does not exist.

        Counts, statistics and, with the first episode, the description change in one journalled step.

        Raises:
            OutputError: If a file cannot be written; the data set is then as it was, or complete once it is opened.
        """
        number = staged.numbering.episode_index
        if number != self.episodes or staged.numbering.index_from != self.rows:
            raise ValueError(f"episode {number} does not follow the {self.episodes} that are there")
        write_json(staged.beside / "provenance.json", provenance)
        try:
            move(staged.data, self.layout.data(number))
            for key in video_keys(features_of(description.contents)):
                move(staged.video(key), self.layout.video(number, key))
            move(staged.beside, self.layout.episode(number))
        except OSError as error:
            self._remove(number)
            where = self.layout.root
            raise OutputError(f"cannot be written ({error.strerror})", where=where, cure="check the space") from error
        task = str(description.robot["task"])
        write_bytes(self.layout.episode_meta(number), episode_entry(staged, description, task))
        stats = aggregate([self._stats, staged.stats]) if self._stats else dict(staged.stats)
        episodes, rows = number + 1, self.rows + staged.rows
        changed = {self.layout.stats: stats, self.layout.info: info_of(description, episodes, rows)}
        if self.description is None:
            write_bytes(self.layout.tasks, task_table(task))
            changed[self.layout.description] = description.to_json()
        for path, content in changed.items():
            write_json(replacement(path), content)
        commit(self.layout.root, list(changed))
        self.episodes, self.rows, self._stats = episodes, rows, stats
        self.description = self.description or description
        self._provenance.append(dict(provenance))
