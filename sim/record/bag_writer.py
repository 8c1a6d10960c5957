"""Recordings written by the libraries of their formats: whole, or not at all."""

import shutil
import sqlite3
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from rosbags.interfaces import Qos, QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime
from rosbags.rosbag1 import Writer as Ros1Writer
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin
from rosbags.rosbag2 import Writer as Ros2Writer
from rosbags.typesys.store import Typestore

from navtool.datasets.recording.identity import recording_sha256
from navtool.sim.errors import SimError
from navtool.sim.record.bag_format import BagFormat
from navtool.sim.record.streams import Entry

_LATCHED = ("/tf_static", "/ground_truth/obstacles", "/ground_truth/surfaces")
"""Topics whose last message a late listener gets too."""
_NO_LIMIT = QosTime(9223372036, 854775807)


def write_bag(
    path: Path,
    kind: BagFormat,
    typestore: Typestore,
    topics: Mapping[str, str],
    entries: Iterable[Entry],
    staging: Path,
) -> tuple[str, int]:
    """Write a recording, and return the SHA-256 and the bytes of what was written.

    Guarantee: the path is there whole, or not; the bytes depend on the entries, the topics and the path's name alone.
    An older recording there is replaced.

    Args:
        path: Where it goes; ends as the format asks.
        kind: Its format.
        typestore: Which knows the topics' types.
        topics: Every topic with its type.
        entries: Messages in the order of recording.
        staging: A folder on the same disk for what is not finished; emptied first, removed afterwards.

    Raises:
        SimError: It cannot be written.
    """
    try:
        shutil.rmtree(staging, ignore_errors=True)
        staging.mkdir(parents=True)
        try:
            unfinished = staging / (path.name if kind is BagFormat.ros1 else path.stem)
            with _writer(unfinished, kind, typestore, topics) as write:
                for entry in entries:
                    write(entry)
            finished = unfinished / path.name if kind is BagFormat.mcap else unfinished
            found = recording_sha256(finished)
            path.parent.mkdir(parents=True, exist_ok=True)
            if path.is_dir():
                shutil.rmtree(path)
            finished.replace(path)
        finally:
            shutil.rmtree(staging, ignore_errors=True)
    except (OSError, sqlite3.Error) as error:
        reason = getattr(error, "strerror", None) or error
        cure = "check the disk's space and the folder's rights"
        raise SimError(f"cannot be written ({reason})", where=path, cure=cure) from error
    return found


@contextmanager
def _writer(
    path: Path, kind: BagFormat, typestore: Typestore, topics: Mapping[str, str]
) -> Iterator[Callable[[Entry], None]]:
    """Open a recording with all topics declared."""
    if kind is BagFormat.ros1:
        with Ros1Writer(path) as bag:
            ids = {
                topic: bag.add_connection(topic, name, typestore=typestore, latching=1 if topic in _LATCHED else None)
                for topic, name in topics.items()
            }
            yield lambda entry: bag.write(ids[entry.topic], entry.record_ns, entry.data)
        return
    plugin = StoragePlugin.MCAP if kind is BagFormat.mcap else StoragePlugin.SQLITE3
    bag2 = Ros2Writer(path, version=9, storage_plugin=plugin)
    if kind is BagFormat.mcap:
        bag2.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
    with bag2:
        ids2 = {
            topic: bag2.add_connection(topic, name, typestore=typestore, offered_qos_profiles=[_qos(topic)])
            for topic, name in topics.items()
        }
        yield lambda entry: bag2.write(ids2[entry.topic], entry.record_ns, entry.data)


def _qos(topic: str) -> Qos:
    """Reliable; what is said once is kept for late listeners."""
    latched = topic in _LATCHED
    return Qos(
        QosHistory.KEEP_LAST,
        1 if latched else 10,
        QosReliability.RELIABLE,
        QosDurability.TRANSIENT_LOCAL if latched else QosDurability.VOLATILE,
        _NO_LIMIT,
        _NO_LIMIT,
        QosLiveliness.AUTOMATIC,
        _NO_LIMIT,
        avoid_ros_namespace_conventions=False,
    )
