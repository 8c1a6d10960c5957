"""What libraries raise on a damaged file of a data set, as errors of navtool's."""

import errno
from pathlib import Path

import av
import pyarrow as pa

from navtool.base.errors import DatasetsError

REBUILD = "run `navtool check` on it; ingest its recording again"
_OF_A_DISK = (errno.ENOSPC, errno.EDQUOT, errno.EROFS)
"""What only writing meets."""


class reading:  # noqa: N801 (used as a statement)
    """Turns what pyarrow and PyAV raise on a damaged or missing file into our error."""

    def __init__(self, path: Path) -> None:
        self._path = path

    def __enter__(self) -> None:
        return None

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: object) -> None:
        if not isinstance(error, OSError | ValueError | pa.ArrowException | av.FFmpegError):
            return
        if not isinstance(error, DatasetsError) and getattr(error, "errno", None) not in _OF_A_DISK:
            first = str(error).splitlines()[0] if str(error) else type(error).__name__
            raise DatasetsError(f"cannot be read ({first})", where=self._path, cure=REBUILD) from error
