"""A calibrated camera brought to the pictures as they were recorded: regions of interest, binning, other sizes.

Reference: REP 104: K, P and the size belong to the whole sensor; a region of interest is given in its pixels and read
out before pixels are binned.
"""

from dataclasses import replace
from typing import NamedTuple

from navtool.base.note import Note
from navtool.datasets.decode.messages import Region
from navtool.pipeline.geometry.camera import CameraModel

_SAME_ASPECT = 0.01
"""Share by which the scales of columns and rows may differ: sizes are rounded to whole pixels."""
_ROUNDED_PX = 1


class Fitted(NamedTuple):
    """The camera of what the pictures show, and what was done to get there."""

    camera: CameraModel
    """At the size of the calibration; pictures of another size are the same ones made smaller or larger."""
    done: str
    """In words, for the calibration's sources; empty where the calibration is that of the pictures."""
    notes: tuple[Note, ...]


def fitted(camera: CameraModel, region: Region, seen: tuple[int, int] | None) -> Fitted:
    """The camera of what the recorded pictures show.

    A region of interest moves the principal point and scales nothing; binning scales. Where pictures have neither the
    size that both give nor the shape of the calibrated picture, the camera is scaled along columns and rows apart, and
    a note says so.

    Args:
        camera: At the size of the calibration.
        region: What the calibration says of the part of the sensor that is read out.
        seen: Width and height of the pictures as recorded; None where none was read.
    """
    whole = camera.width, camera.height
    notes: list[Note] = []
    part = camera
    if any(region.size) and not _inside(region, whole):
        notes.append(_not_believed(region, f"it does not lie within the {_size(whole)} pixels of the calibration"))
    elif any(region.size) and region.size != whole:
        part = _cropped(camera, region)
    read_out = part.width // region.binning[0], part.height // region.binning[1]
    size = seen or read_out
    if part is not camera and not (_close(size, read_out) or _same_shape(size, (part.width, part.height))):
        unbinned = whole[0] // region.binning[0], whole[1] // region.binning[1]
        if _close(size, unbinned) or _same_shape(size, whole):
            notes.append(_not_believed(region, f"the pictures, {_size(size)}, have the shape of the whole sensor"))
            part = camera
    elif part is not camera and _larger(size, region.size) and _same_shape(size, whole):
        notes.append(
            _not_believed(region, f"the pictures, {_size(size)}, are larger, and have the whole sensor's shape")
        )
        part = camera
    if not (_close(size, read_out) or _same_shape(size, (part.width, part.height))):
        notes.append(
            Note(
                "camera.other-shape",
                f"calibrated at {_size((part.width, part.height))}, pictures of {_size(size)}: scaled along columns "
                "and rows apart, as if they were stretched; if they are cut out of it, give their own calibration as "
                "camera in the robot file, with camera_info: [none]",
            )
        )
    return Fitted(part, _done(camera, part, region, size), tuple(notes))


def _cropped(camera: CameraModel, region: Region) -> CameraModel:
    (x, y), (width, height) = region.offset, region.size
    return replace(camera, width=width, height=height, cx=camera.cx - x, cy=camera.cy - y)


def _inside(region: Region, whole: tuple[int, int]) -> bool:
    return all(start + size <= most for start, size, most in zip(region.offset, region.size, whole, strict=True))


def _larger(size: tuple[int, int], other: tuple[int, int]) -> bool:
    return all(one - two > _ROUNDED_PX for one, two in zip(size, other, strict=True))


def _close(size: tuple[int, int], other: tuple[int, int]) -> bool:
    return all(abs(one - two) <= _ROUNDED_PX for one, two in zip(size, other, strict=True))


def _same_shape(size: tuple[int, int], other: tuple[int, int]) -> bool:
    across, down = size[0] / other[0], size[1] / other[1]
    rounded = max(_ROUNDED_PX / size[0], _ROUNDED_PX / size[1])
    return abs(across / down - 1) <= max(_SAME_ASPECT, rounded)


def _not_believed(region: Region, why: str) -> Note:
    where = f"{_size(region.size)} at ({region.offset[0]}, {region.offset[1]})"
    return Note("camera.region-unused", f"its CameraInfo names a region of interest of {where}, but {why}: left out")


def _done(camera: CameraModel, part: CameraModel, region: Region, size: tuple[int, int]) -> str:
    if size == (camera.width, camera.height):
        return ""
    said = f", calibrated at {_size((camera.width, camera.height))}"
    if part is not camera:
        said += f", region of interest {_size(region.size)} at ({region.offset[0]}, {region.offset[1]})"
    return said + ("" if part is not camera and size == (part.width, part.height) else f", recorded at {_size(size)}")


def _size(size: tuple[int, int]) -> str:
    return f"{size[0]}x{size[1]}"
