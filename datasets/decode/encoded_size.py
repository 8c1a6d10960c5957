"""The size that a compressed image states, read before anything is decompressed."""

from navtool.base.errors import DatasetsError

_PNG = b"\x89PNG\r\n\x1a\n"
_FRAME_HEADERS = (*range(0xC0, 0xC4), *range(0xC5, 0xC8), *range(0xC9, 0xCC), *range(0xCD, 0xD0))
"""JPEG's markers of a frame header, one for each way of coding."""

MOST_PIXELS = 100_000_000
"""No robot's camera has more."""


def encoded_size(data: bytes) -> tuple[int, int]:
    """Width and height as a JPEG or PNG image states them; 0 where they do not show and the decoder has to say."""
    if data.startswith(_PNG):
        return int.from_bytes(data[16:20]), int.from_bytes(data[20:24])
    offset = 2
    while offset + 9 <= len(data) and data[offset] == 0xFF:
        marker = data[offset + 1]
        if marker in _FRAME_HEADERS:
            return int.from_bytes(data[offset + 7 : offset + 9]), int.from_bytes(data[offset + 5 : offset + 7])
        # A marker may be filled up with any number of 0xFF in front.
        offset += 1 if marker == 0xFF else 2 + int.from_bytes(data[offset + 2 : offset + 4])
    return 0, 0


def refuse_giants(data: bytes) -> None:
    """Do nothing, but for an image whose size is beyond all measure: decoders fill what is missing with grey.

    Raises:
        DatasetsError: It is beyond `MOST_PIXELS`.
    """
    width, height = encoded_size(data)
    if width * height > MOST_PIXELS:
        raise DatasetsError(f"damaged image of {len(data)} bytes: it says that it has {width}x{height} pixels")
