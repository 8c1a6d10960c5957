"""Files that rosbag2 compressed as a whole (``compression_mode: FILE``)."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import BinaryIO

import zstandard

from navtool.base.errors import DatasetsError
from navtool.datasets.recording.foreign import translated

_MAGIC = b"\x28\xb5\x2f\xfd"
_BLOCK_BYTES = 1 << 20


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
            _decompress(stream, target)
        yield contents


def _decompress(stream: BinaryIO, target: BinaryIO) -> None:
    frame = zstandard.ZstdDecompressor().decompressobj()
    while block := stream.read(_BLOCK_BYTES):
        while block:
            if frame.eof:
                frame = zstandard.ZstdDecompressor().decompressobj()
            target.write(frame.decompress(block))
            block = frame.unused_data
    if not frame.eof:
        raise DatasetsError("the compressed file is truncated", cure="copy it again")
