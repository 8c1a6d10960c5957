"""The layouts that are written out are those of ROS's own definitions."""

import pytest

from navtool.datasets.recording.message_type import message_type
from navtool.datasets.streams.usual_layout import USUAL, usual_layout


@pytest.mark.parametrize("encoding", ["ros1", "cdr"])
@pytest.mark.parametrize("name", USUAL)
def test_every_usual_layout_is_that_of_the_definitions(name: str, encoding: str) -> None:
    assert usual_layout(name, encoding) == message_type(name, encoding, None, "humble").layout()


def test_no_other_type_has_one() -> None:
    assert usual_layout("sensor_msgs/msg/PointCloud2", "cdr") is None
    assert usual_layout("geometry_msgs/msg/Twist", "ros1") is None
