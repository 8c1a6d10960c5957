"""Messages that rosbag2 compressed one by one (``compression_mode: MESSAGE``)."""

import zstandard

_MAGIC = b"\x28\xb5\x2f\xfd"


def decompressed(data: bytes) -> bytes:
    """The serialised message, decompressed where it is a zstd frame.

    The mode is noted only in the ``metadata.yaml`` of the whole recording, which a single file of it lacks. The bytes
    show it as well: a CDR message starts with 0, the first byte of its encapsulation, and never with zstd's magic.

    A damaged frame is left as it is: reading goes on, and only decoding this message fails.
    """
    if data[:4] != _MAGIC:
        return data
    frame = zstandard.ZstdDecompressor().decompressobj()
    try:
        content = frame.decompress(data)
    except zstandard.ZstdError:
        return data
    return content if frame.eof else data
