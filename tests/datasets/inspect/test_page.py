"""The page of a recording holds everything itself, escapes what comes from the bag, and is the same every time."""

import base64
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from navtool.datasets.inspect.inspection import inspect_recording
from navtool.datasets.inspect.page import recording_page
from navtool.datasets.inspect.samples import take_samples


def _page(path: Path) -> str:
    inspection = inspect_recording(path)
    return recording_page(inspection, take_samples(path, inspection))


def _pictures(page: str) -> list[Any]:
    found = re.findall(r"data:image/(?:png|jpeg);base64,([A-Za-z0-9+/=]+)", page)
    return [cv2.imdecode(np.frombuffer(base64.b64decode(content), np.uint8), cv2.IMREAD_COLOR) for content in found]


def test_a_whole_drive_on_one_page(write_recording: Callable[..., Path], drive_entries: Callable[..., Any]) -> None:
    path = write_recording("mcap", drive_entries(12.0, crash=False))
    page = _page(path)
    assert page == _page(path)
    assert not re.search(r"""(src|href)=["'](?!data:)|<script|@import|url\(""", page)
    assert page.count("<h2>") == 7
    frames = [picture for picture in _pictures(page) if picture.shape[:2] == (255, 340)]
    assert len(frames) == 3
    above, side = (picture for picture in _pictures(page) if picture.shape[:2] != (255, 340))
    assert above.shape[0] == above.shape[1] == 3 * side.shape[0]
    assert (above.reshape(-1, 3) != above[0, 0]).any(axis=1).sum() > 200, "points are drawn"
    assert re.search(r"1[12]\.\d m by the odometry", page)
    assert "1.0" in re.findall(r"(\d\.\d)\d m/s", page)


def test_texts_of_the_recording_are_escaped(write_recording: Callable[..., Path]) -> None:
    evil = "/<script>alert(1)</script>&\"'"
    page = _page(write_recording("mcap", [(evil, "std_msgs/msg/String", 10**9 + k, {"data": "x"}) for k in range(3)]))
    assert "<script" not in page
    assert "&lt;script&gt;alert(1)&lt;/script&gt;&amp;&quot;&#x27;" in page
    assert "No topic fits" in page


def test_pauses_and_damage_are_shown(
    write_recording: Callable[..., Path], drive_entries: Callable[..., Any], tmp_path: Path
) -> None:
    start = drive_entries()[0][2]
    entries = [x for x in drive_entries(20.0) if not (x[0] == "/points" and 5e9 < x[2] - start < 10e9)]
    page = _page(write_recording("mcap", entries))
    lanes = re.split(r'<text x="0"', page)[1:]
    lidar = next(lane for lane in lanes if "/points<" in lane)
    bars = [(float(x), float(w)) for x, w in re.findall(r'class="bar" x="([\d.]+)" y="\d+" width="([\d.]+)"', lidar)]
    ends = [x + w for x, w in bars]
    widest = max(after[0] - end for end, after in zip(ends[:-1], bars[1:], strict=True))
    assert 0.2 < widest / 760 < 0.27, "a quarter of the lane is empty"
    whole = write_recording("ros1", drive_entries(8.0, ros1=True), name="whole").read_bytes()
    torn = tmp_path / "torn.bag"
    torn.write_bytes(whole[: len(whole) * 3 // 4])
    assert "cut off after" in _page(torn)
    broken = [
        (t, k, at, f | {"data": np.zeros(4)} if t.endswith("compressed") else f) for t, k, at, f in drive_entries()
    ]
    page = _page(write_recording("mcap", broken, name="broken"))
    assert "neither JPEG nor PNG" in page
