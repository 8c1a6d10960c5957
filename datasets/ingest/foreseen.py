"""A data set as an ingest would leave it, for plans: it is read once, and nothing is locked or written."""

import time
from collections.abc import Mapping
from pathlib import Path

from navtool.base.errors import DatasetsError
from navtool.datasets.store.description import Description
from navtool.datasets.store.journal import journal_path
from navtool.datasets.store.layout import Layout
from navtool.datasets.store.writer import Store, data_set_folder

_PATIENCE_S = 1.0


class Foreseen(Store):
    """Counts the episodes that an ingest would add to a data set or replace in it."""

    def foresee(self, description: Description, provenance: Mapping[str, object], rows: int) -> tuple[int, bool]:
        """The number that an episode of so many rows would have, and whether it would replace an older one."""
        source, sha256 = str(provenance["source"]), str(provenance["sha256"])
        replaced = self.episode_from(source, sha256, int(str(provenance["recording_start_ns"])))
        self.description = self.description or description
        if replaced is not None:
            self._provenance[replaced] = dict(provenance)
            return replaced, True
        self._provenance.append(dict(provenance))
        self.episodes, self.rows = self.episodes + 1, self.rows + rows
        return self.episodes - 1, False

    def _write_provenance(self, episode: int) -> None:
        """Leave the file as it is."""
        del episode


def foresee(root: Path) -> Foreseen:
    """The data set in a folder as it is at one moment; an empty one where there is none yet.

    Raises:
        DatasetsError: The folder holds something else, its metadata is damaged, or a step of another process is
            under way or was interrupted.
    """
    data_set_folder(root).refuse_other()
    layout, patience = Layout(root), time.monotonic() + _PATIENCE_S
    while True:
        before = _moment(layout)
        try:
            store = Foreseen(layout)
        except DatasetsError:
            if _moment(layout) == before and not journal_path(root).exists():
                raise
        else:
            if _moment(layout) == before and not journal_path(root).exists():
                return store
        if time.monotonic() > patience:
            cure = "wait until it is done; if none runs, `navtool check` finishes the step"
            raise DatasetsError("another process is writing to it, or was interrupted", where=root, cure=cure)
        time.sleep(0.02)


def _moment(layout: Layout) -> tuple[int, int] | None:
    """Another one after each step that changes the data set: all of them write its description of LeRobot's anew."""
    try:
        status = layout.info.stat()
    except FileNotFoundError:
        return None
    return status.st_ino, status.st_mtime_ns
