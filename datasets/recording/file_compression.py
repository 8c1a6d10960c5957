"""Files that rosbag2 compressed as a whole (``compression_mode: FILE``)."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

import zstandard

from navtool.datasets.recording.foreign import translated

_MAGIC = b"\x28\xb5\x2f\xfd"


@contextmanager
def unpacked(file: Path) -> Iterator[Path]:
    """The file itself, or where it is a zstd frame, its contents in the temporary folder while the context lasts.

    Raises:
        DatasetsError: The file cannot be read or decompressed.
    """
    with translated("the file cannot be opened", where=file), file.open("rb") as stream:
        packed = stream.read(len(_MAGIC)) == _MAGIC
    if not packed:
        yield file
        return
    with TemporaryDirectory(prefix="navtool-zstd-") as folder:
        contents = Path(folder, file.stem)
        with (
            translated("the file cannot be decompressed", where=file, cure="copy it again"),
            file.open("rb") as stream,
            contents.open("wb") as target,
        ):
            zstandard.ZstdDecompressor().copy_stream(stream, target)
        yield contents
