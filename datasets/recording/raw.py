"""What a recording holds, before anything is decoded."""

from dataclasses import dataclass
from enum import StrEnum
from typing import NamedTuple


class RecordingFormat(StrEnum):
    """How a recording is stored."""

    ros1 = "ros1"
    ros2_db3 = "ros2_db3"
    mcap = "mcap"


@dataclass(frozen=True, slots=True)
class Topic:
    """A topic of a recording; a topic that carries two types is listed once for each."""

    name: str
    type: str
    """Normalised to ``package/msg/Name`` where it is a ROS type."""
    count: int


class RawMessage(NamedTuple):
    """One message as recorded, not yet decoded."""

    topic: str
    type: str
    record_ns: int
    """When the recorder received it; its header's stamp is in the bytes."""
    data: bytes
    publisher: str = ""
    """The node that published it, where the format says so."""
