"""Which topics belong to one camera, by their names."""

import re

_TRANSPORTS = re.compile(r"/(compressed|compressedDepth|theora|ffmpeg|zstd|zlib|draco|cloudini)$")


def camera_name(topic: str) -> str:
    """The image topic's name without an image transport's suffix: equal for all encodings of the same image."""
    return _TRANSPORTS.sub("", topic)


def camera_namespaces(topic: str) -> tuple[str, ...]:
    """The namespaces that may hold the image's CameraInfo, nearest first."""
    parent = camera_name(topic).rpartition("/")[0]
    return (camera_name(topic), parent)
