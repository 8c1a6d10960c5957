"""``navtool inspect``."""

from pathlib import Path
from typing import TYPE_CHECKING

import typer

if TYPE_CHECKING:
    from navtool.datasets.inspect.inspection import Inspection

_ONE_TABLE_COLUMNS = 130
"""Width of a terminal in characters from which a topic's row takes everything without folding its name."""

_FURTHER = "more cameras or LiDARs, read where a robot file names them; --write-robot FILE writes one"


def inspect(
    bag: str = typer.Argument(
        ..., help="A .bag, .mcap or .db3 file, a rosbag2 folder, or a URL of one.", show_default=False
    ),
    robot: str | None = typer.Option(None, "--robot", help="Robot preset or file whose topics to look for."),
    write_robot: Path | None = typer.Option(
        None, "--write-robot", help="Save the topic map as a new robot file to edit, in a folder that is there."
    ),
    report: Path | None = typer.Option(
        None, "--report", help="Write the recording as one HTML page, into a folder that is there."
    ),
    as_json: bool = typer.Option(False, "--json", help="Print JSON."),
) -> None:
    """Show what is in a recording.

    Topics, types, rates, gaps, the distance between header and record clocks, and which topic ingest would take for
    which stream.
    """
    from navtool.cli.arguments import local_path, require_folder_for
    from navtool.cli.compose import UsageError
    from navtool.cli.console import console, print_json, print_notes
    from navtool.cli.robots import find_robot
    from navtool.datasets.inspect.inspection import inspect_recording, robot_from
    from navtool.datasets.robot.config import save_robot_file

    require_folder_for(report, write_robot)
    if write_robot is not None and write_robot.exists():
        raise UsageError("is there already", where=write_robot, cure="name another file, or remove it")
    base = find_robot(robot, ())
    recording = local_path(bag)
    inspection = inspect_recording(recording, base)
    if write_robot is not None:
        save_robot_file(robot_from(base, inspection), write_robot)
    if report is not None:
        _draw(recording, inspection, report)
    if as_json:
        print_json(inspection.to_json())
        return
    print_inspection(inspection)
    if inspection.topic_map.further and write_robot is None:
        print_notes([f"{_FURTHER}: {', '.join(inspection.topic_map.further)}"])
    if report is not None:
        console().print(f"report: {report}", markup=False)
    if write_robot is not None:
        console().print(f"robot file: {write_robot}", markup=False)


def _draw(recording: Path, inspection: "Inspection", report: Path) -> None:
    """Write the recording as one page."""
    from navtool.base.files import write_bytes
    from navtool.cli.console import console
    from navtool.datasets.inspect.page import recording_page
    from navtool.datasets.inspect.samples import take_samples

    with console(error=True).status("drawing"):
        page = recording_page(inspection, take_samples(recording, inspection))
    write_bytes(report, page.encode())


def print_inspection(inspection: "Inspection") -> None:
    """The recording for a person: a row for each topic where there is room for it, else two; then what is not used."""
    from navtool.cli.console import console, print_notes, print_table

    out = console()
    span_s = (inspection.end_ns - inspection.start_ns) * 1e-9
    out.print(f"{inspection.path}: {inspection.format}, {inspection.messages} messages, {span_s:.1f} s", markup=False)
    used = {topic: stream for stream, topic in inspection.topic_map.streams.items()}
    used |= dict.fromkeys(inspection.topic_map.transforms, "transforms")
    used |= {topic: f"(could be {stream})" for stream, topic in inspection.topic_map.further.items()}
    feeds = {topic.name: (topic.name, topic.type, used.get(topic.name, "not used")) for topic in inspection.topics}
    times = {
        topic.name: (topic.count, topic.rate_hz, topic.gap_max_s, topic.time, topic.clock_offset_s)
        for topic in inspection.topics
    }
    time_columns = ("count", "rate\nHz", "longest\ngap s", "time", "header -\nrecord s")
    if out.width >= _ONE_TABLE_COLUMNS:
        columns = ("topic", "type", "feeds", *time_columns)
        print_table("Topics", columns, ((*feeds[name], *times[name]) for name in feeds))
    else:
        print_table("Topics", ("topic", "type", "feeds"), feeds.values())
        print_table("Messages", ("topic", *time_columns), ((name, *times[name]) for name in feeds))
    if unused := inspection.topic_map.not_used:
        print_table("Not used", ("topic", "reason"), ((topic.name, topic.reason) for topic in unused))
    print_notes(f"damaged: {fault}" for fault in inspection.faults)
    print_notes(inspection.topic_map.notes)
    print_notes(inspection.notes)
