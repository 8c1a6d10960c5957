"""Clouds that point_cloud_transport packed, against the PointCloud2 that they were made of."""

import zlib
from collections.abc import Callable
from typing import Any

import DracoPy
import numpy as np
import pytest
import zstandard

from navtool.base.errors import DatasetsError
from navtool.datasets.decode.compressed_cloud import decode_compressed_cloud
from navtool.datasets.decode.point_cloud import decode_point_cloud

type Make = Callable[..., Any]
KIND = "point_cloud_interfaces/msg/CompressedPointCloud2"
OLD = "draco_point_cloud_transport/msg/CompressedPointCloud2"
NAMES = ("x", "y", "z", "intensity", "ring")


def table() -> Any:
    rng = np.random.default_rng(3)
    points = np.zeros(200, [("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("intensity", "<f4"), ("ring", "<u2")])
    for axis in "xyz":
        points[axis] = rng.uniform(-20, 20, 200)
    points["intensity"], points["ring"] = np.arange(200), np.arange(200) % 16
    return points


def cloud() -> dict[str, Any]:
    points = table()
    kinds = {"x": 7, "y": 7, "z": 7, "intensity": 7, "ring": 4}
    step = points.dtype.itemsize
    return {
        "header": {"stamp": {"sec": 5, "nanosec": 6}, "frame_id": "lidar"},
        "height": 1,
        "width": 200,
        "fields": [{"name": n, "offset": points.dtype.fields[n][1], "datatype": kinds[n], "count": 1} for n in NAMES],
        "point_step": step,
        "row_step": 200 * step,
        "is_dense": True,
    }


def by_draco() -> bytes:
    points = table()
    xyz = np.stack([points[axis] for axis in "xyz"], axis=-1)
    others = {1: points["intensity"][:, None], 2: points["ring"][:, None]}
    return bytes(DracoPy.encode(xyz, quantization_bits=16, preserve_order=True, generic_attributes=others))


@pytest.mark.parametrize("kind", [KIND, OLD])
@pytest.mark.parametrize("form", ["draco", "zlib", "zstd"])
def test_a_packed_cloud_is_the_one_that_was_packed(form: str, kind: str, ros_message: Make) -> None:
    content = table().tobytes()
    packed = {
        "draco": by_draco(),
        "zlib": zlib.compress(content),
        "zstd": zstandard.ZstdCompressor().compress(content),
    }[form]
    right = decode_point_cloud(
        ros_message("sensor_msgs/msg/PointCloud2", {**cloud(), "data": np.frombuffer(content, np.uint8)})
    )
    fields = {**cloud(), "compressed_data": np.frombuffer(packed, np.uint8)}
    if kind == KIND:
        fields["format"] = form
    found = decode_compressed_cloud(ros_message(kind, fields))
    assert (found.stamp_ns, found.frame_id) == (right.stamp_ns, right.frame_id)
    np.testing.assert_allclose(found.xyz, right.xyz, atol=1e-3 if form == "draco" else 0)
    np.testing.assert_array_equal(found.intensity, right.intensity)
    np.testing.assert_array_equal(found.ring, right.ring)
    assert not found.notes


def streamed(content: bytes, size: int = -1) -> bytes:
    """A zstd frame whose head says this size; none by default."""
    frame = zstandard.ZstdCompressor().compressobj(size=size)
    try:
        return bytes(frame.compress(content) + frame.flush())
    except zstandard.ZstdError:
        return b"\x28\xb5\x2f\xfd\xa0" + size.to_bytes(4, "little") + content


@pytest.mark.parametrize("size", [-1, len(table().tobytes())])
def test_a_frame_says_its_size_or_not(size: int, ros_message: Make) -> None:
    data = np.frombuffer(streamed(table().tobytes(), size), np.uint8)
    found = decode_compressed_cloud(ros_message(KIND, {**cloud(), "compressed_data": data, "format": "zstd"}))
    assert len(found.xyz) == 200


@pytest.mark.parametrize(
    ("data", "told"),
    [
        (by_draco()[:40], "damaged point cloud"),
        (b"DRACO" + bytes(20), "damaged point cloud"),
        (zlib.compress(bytes(4400))[:10] + bytes(5), "damaged|truncated"),
        (zstandard.ZstdCompressor().compress(table().tobytes())[:200], "damaged|truncated"),
        (zlib.compress(table().tobytes())[:-20], "damaged point cloud: its [0-9]+ compressed bytes are not all"),
        (zstandard.ZstdCompressor().compress(table().tobytes())[:-20], "damaged point cloud: it cannot"),
        (streamed(table().tobytes())[:-4], "damaged point cloud: it cannot"),
        (streamed(table().tobytes(), (1 << 29)), "larger than any"),
        (b"CLOUDINI_V02", "compressed as 'cloudini', which is not decoded; draco"),
    ],
)
def test_damage_and_other_compressions_are_refused(data: bytes, told: str, ros_message: Make) -> None:
    fields = {**cloud(), "compressed_data": np.frombuffer(data, np.uint8), "format": "cloudini"}
    with pytest.raises(DatasetsError, match=told):
        decode_compressed_cloud(ros_message(KIND, fields))


def test_without_the_library_the_extra_is_named(ros_message: Make, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "DracoPy", None)
    fields = {**cloud(), "compressed_data": np.frombuffer(by_draco(), np.uint8)}
    with pytest.raises(DatasetsError, match="whose library is not installed") as caught:
        decode_compressed_cloud(ros_message(KIND, fields))
    assert caught.value.cure == "pip install 'navtool[draco]'"
