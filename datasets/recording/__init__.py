"""Recordings of robots: ROS 1 bags, ROS 2 db3, MCAP."""

from navtool.datasets.recording.opening import open_recording
from navtool.datasets.recording.raw import RawMessage, RecordingFormat, Topic
from navtool.datasets.recording.recording import Recording

__all__ = ["RawMessage", "Recording", "RecordingFormat", "Topic", "open_recording"]
