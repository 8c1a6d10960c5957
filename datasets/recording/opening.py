"""Opening a recording: what the path is, and which files belong to it."""

from contextlib import ExitStack, closing
from pathlib import Path

from navtool.base.errors import DatasetsError
from navtool.datasets.recording.db3_source import Db3Source
from navtool.datasets.recording.file_compression import unpacked
from navtool.datasets.recording.folder import all_files_of, files_of, recordings_in
from navtool.datasets.recording.foreign import translated
from navtool.datasets.recording.mcap_source import McapSource
from navtool.datasets.recording.message_type import check_ros_distro
from navtool.datasets.recording.raw import RecordingFormat
from navtool.datasets.recording.recording import Recording
from navtool.datasets.recording.ros1_source import Ros1Source
from navtool.datasets.recording.source import Source

_MAGIC = {
    b"#ROSBAG V": RecordingFormat.ros1,
    b"SQLite format 3\0": RecordingFormat.ros2_db3,
    b"\x89MCAP": RecordingFormat.mcap,
}


def open_recording(path: Path, *, ros_distro: str = "humble", merged: bool = False, verify: bool = True) -> Recording:
    """The recording at a path, to be used as a context manager.

    Args:
        path: A ROS 1 ``.bag``, a ROS 2 ``.db3``, an ``.mcap``, or the folder of a ROS 2 recording. The bytes decide,
            not the name. One file of a split recording is a recording of its own.
        merged: Whether all recordings in a folder are one, as the bags of a mission are, one a sensor; they may be of
            several formats.
        verify: Whether checksums are compared; not needed of a recording that was just read through without a fault.
        ros_distro: ROS 2 distribution whose message definitions stand in where the recording embeds none.

    Raises:
        DatasetsError: It is not there, not a recording, damaged, or stored in a way that is not supported.
    """
    check_ros_distro(ros_distro)
    mission = merged and path.is_dir() and not is_one(path)
    files, notes = all_files_of(path, span_of) if mission else files_of(path, span_of)
    with ExitStack() as resources:
        opened, faults = _opened(files, resources, verify=verify)
        formats = [kind for kind, _ in opened]
        if len(set(formats)) > 1 and not mission:
            raise DatasetsError(f"its files have different formats: {', '.join(sorted(set(formats)))}", where=path)
        return Recording(
            path,
            formats[0],
            [source for _, source in opened],
            ros_distro=ros_distro,
            resources=resources.pop_all(),
            notes=notes,
            faults=faults,
        )


def recordings_below(folder: Path) -> list[Path]:
    """The recordings in a folder, to any depth, each by the path that opens it: see `recordings_in`.

    Raises:
        DatasetsError: A folder cannot be read.
    """
    return recordings_in(folder, span_of)


def is_one(folder: Path) -> bool:
    """Whether a folder is one recording, and not one that holds some."""
    return recordings_in(folder, span_of) == [folder]


def span_of(file: Path) -> tuple[int, int] | None:
    """First and last time of record of a file; None where they are not known without unpacking or repairing it."""
    try:
        kind = _format_of(file, file)
        with closing(_source(kind, file, where=file, verify=False)) as source:
            return source.span_ns
    except DatasetsError:
        return None


def _opened(
    files: list[Path], resources: ExitStack, *, verify: bool
) -> tuple[list[tuple[RecordingFormat, Source]], list[str]]:
    """The files that can be opened, and of a recording of several what is wrong with the others.

    Raises:
        DatasetsError: None can be.
    """
    opened: list[tuple[RecordingFormat, Source]] = []
    faults: list[str] = []
    first: DatasetsError | None = None
    for file in files:
        try:
            # Contents lie elsewhere than the file where it is compressed as a whole; errors name the file.
            content = resources.enter_context(unpacked(file))
            kind = _format_of(content, file)
            opened.append((kind, resources.enter_context(closing(_source(kind, content, where=file, verify=verify)))))
        except DatasetsError as error:
            first = first or error
            faults.append(f"{file.name} is left out: {error.what}")
    if first is not None and not opened:
        raise first
    return opened, faults


def _source(recording_format: RecordingFormat, content: Path, *, where: Path, verify: bool) -> Source:
    match recording_format:
        case RecordingFormat.ros1:
            return Ros1Source(content, where=where)
        case RecordingFormat.ros2_db3:
            return Db3Source(content, where=where)
        case RecordingFormat.mcap:
            return McapSource(content, where=where, verify=verify)


def _format_of(content: Path, file: Path) -> RecordingFormat:
    with translated("the file cannot be opened", where=file), content.open("rb") as stream:
        head = stream.read(16)
    if not head:
        raise DatasetsError("the file is empty", where=file, cure="record or copy it again")
    for magic, recording_format in _MAGIC.items():
        if head.startswith(magic):
            return recording_format
    raise DatasetsError(
        "this is not a recording: its first bytes are those of no ROS 1 bag, db3 or MCAP file",
        where=file,
        cure="pass a .bag, a .db3, an .mcap or the folder of a ROS 2 recording",
    )
