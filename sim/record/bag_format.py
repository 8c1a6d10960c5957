"""The formats of recordings that can be written."""

from enum import StrEnum


class BagFormat(StrEnum):
    """How a recording is stored."""

    mcap = "mcap"
    """ROS 2, one file, compressed with zstd."""
    db3 = "db3"
    """ROS 2, a folder with SQLite and its metadata.yaml."""
    ros1 = "ros1"
    """ROS 1, one .bag file."""

    @property
    def suffix(self) -> str:
        """How a recording's name ends; a db3 recording is a folder and has none."""
        return {BagFormat.mcap: ".mcap", BagFormat.ros1: ".bag", BagFormat.db3: ""}[self]
