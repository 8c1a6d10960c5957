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
            for block in _decompressed(stream):
                target.write(block)
        yield contents


def unpacked_bytes(file: Path) -> int:
    """How many bytes a file holds that is compressed as a whole, without keeping them.

    Raises:
        DatasetsError: It cannot be read or decompressed.
    """
    with translated("the file cannot be decompressed", where=file, cure="copy it again"), file.open("rb") as stream:
        return sum(map(len, _decompressed(stream)))


def _decompressed(stream: BinaryIO) -> Iterator[bytes]:
    frame = zstandard.ZstdDecompressor().decompressobj()
    while block := stream.read(_BLOCK_BYTES):
        while block:
            if frame.eof:
                frame = zstandard.ZstdDecompressor().decompressobj()
            yield frame.decompress(block)
            block = frame.unused_data
    if not frame.eof:
        raise DatasetsError("the compressed file is truncated", cure="copy it again")
