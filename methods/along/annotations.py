"""What is known to stand where a recording was made: drawn by hand, or known to the simulator."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from jaxtyping import Float64

from navtool.base.errors import DatasetsError
from navtool.base.from_plain import did_you_mean
from navtool.pipeline.arrays import Array
from navtool.pipeline.intensity_map.obstacles import CellClass
from navtool.pipeline.intensity_map.truth import Outline

CLASSES = {what.name: what for what in (CellClass.solid, CellClass.pliable, CellClass.transparent)}
"""What an obstacle can be. What is not drawn is free."""
_FAULTS_SHOWN = 20
_LEAST_M2 = 1e-6


@dataclass(frozen=True, slots=True)
class Annotations:
    """Outlines of the obstacles of one place."""

    frame_id: str
    """The frame of all corners: one that does not move, such as odom or map."""
    outlines: tuple[Outline, ...]
    """In the document's order."""


def read_annotations(path: Path) -> Annotations:
    """The annotations in a file.

    Raises:
        DatasetsError: The file cannot be read, or as `parse_annotations`.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        raise DatasetsError(f"cannot be read ({error.strerror})", where=path, cure="check the path") from error
    except UnicodeDecodeError as error:
        raise DatasetsError("is not text in UTF-8", where=path, cure="save it as UTF-8") from error
    return parse_annotations(text, path)


def parse_annotations(text: str, where: str | Path) -> Annotations:
    """The annotations of a document, such as a simulated recording has on /ground_truth/obstacles.

    Keys beside ``class`` and ``outline_m`` say more of an obstacle than is asked here and are passed over.

    Args:
        text: JSON.
        where: The file or topic that it comes from, for messages.

    Raises:
        DatasetsError: It is not JSON, or has faults; all of them are named, up to twenty one by one.
    """
    try:
        content = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise DatasetsError(f"is not JSON ({error})", where=where, cure="correct the syntax") from error
    if not isinstance(content, dict):
        raise DatasetsError("is not an object", where=where, cure='begin with {"frame_id": "odom", "obstacles": [...]}')
    faults: list[str] = []
    frame_id = content.get("frame_id")
    if not isinstance(frame_id, str) or not frame_id:
        faults.append(f"frame_id is {_shown(frame_id)}, wanted the name of the frame of the corners, such as odom")
    obstacles = content.get("obstacles")
    if not isinstance(obstacles, list):
        faults.append(f"obstacles is {_shown(obstacles)}, wanted a list")
        obstacles = []
    outlines = [_outline(entry, f"obstacles[{number}]", faults) for number, entry in enumerate(obstacles)]
    if faults:
        more = len(faults) - _FAULTS_SHOWN
        shown = [*faults[:_FAULTS_SHOWN], *([f"and {more} faults more"] if more > 0 else [])]
        cure = "correct what is named; docs/annotations.md has the format"
        raise DatasetsError("; ".join(shown), where=where, cure=cure)
    return Annotations(str(frame_id), tuple(one for one in outlines if one is not None))


def _outline(entry: object, place: str, faults: list[str]) -> Outline | None:
    if not isinstance(entry, Mapping):
        faults.append(f"{place} is {_shown(entry)}, wanted an object with class and outline_m")
        return None
    before = len(faults)
    name = entry.get("class")
    if not isinstance(name, str) or name not in CLASSES:
        hint = did_you_mean(name, list(CLASSES)) if isinstance(name, str) else ""
        faults.append(f"{place}.class is {_shown(name)}{hint}, known are {', '.join(CLASSES)}")
    corners = entry.get("outline_m")
    if not isinstance(corners, list) or len(corners) < 3:
        faults.append(f"{place}.outline_m is {_shown(corners)}, wanted three corners [x, y] or more, in metres")
    else:
        faults.extend(
            f"{place}.outline_m[{number}] is {_shown(corner)}, wanted [x, y] in metres"
            for number, corner in enumerate(corners)
            if not _is_corner(corner)
        )
    if len(faults) > before:
        return None
    if _area_m2(np.array(corners, np.float64)) < _LEAST_M2:
        faults.append(f"{place}.outline_m has no area: its corners lie on a line")
        return None
    return Outline(CLASSES[str(name)], np.array(corners, np.float64))


def _area_m2(corners: Float64[Array, "k 2"]) -> float:
    """Area of the convex hull: an outline that crosses itself encloses something all the same."""
    return float(cv2.contourArea(cv2.convexHull((corners - corners[0]).astype(np.float32))))


def _is_corner(corner: object) -> bool:
    """Whether these are two finite numbers; JSON's whole numbers can be too large for any metres."""
    if not isinstance(corner, list) or len(corner) != 2:
        return False
    return all(isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 1e9 for value in corner)


def _shown(value: object) -> str:
    """What stands there, cut to a line."""
    text = "missing" if value is None else json.dumps(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
