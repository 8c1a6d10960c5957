"""Results drawn: each once, for all that show it."""

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import cv2
from jaxtyping import UInt8

from navtool.base.files import write_bytes
from navtool.methods.along.writers import Outcome, Selection, Writer
from navtool.pipeline.arrays import Array


class Drawn[R]:
    """The picture of a result, drawn and compressed when the first writer asks for it.

    Writers that show the same pictures share one of it. Memory holds the picture of the last result.
    """

    def __init__(self, draw: Callable[[Outcome[R]], UInt8[Array, "h w 3"]]) -> None:
        """Draw with a function.

        Args:
            draw: Gives a picture in OpenCV's order of colours; all have one size, and even sides.
        """
        self._draw = draw
        self._sheet: tuple[int, UInt8[Array, "h w 3"]] | None = None
        self._png: tuple[int, bytes] | None = None

    def sheet(self, outcome: Outcome[R]) -> UInt8[Array, "h w 3"]:
        """The picture."""
        if self._sheet is None or self._sheet[0] != outcome.number:
            self._sheet = outcome.number, self._draw(outcome)
        return self._sheet[1]

    def png(self, outcome: Outcome[R]) -> bytes:
        """The picture as PNG."""
        if self._png is None or self._png[0] != outcome.number:
            self._png = outcome.number, png_bytes(self.sheet(outcome))
        return self._png[1]


class PictureFiles[R](Writer[R]):
    """Writes pictures, ``000000.png`` on."""

    def __init__(self, folder: Path, drawn: Drawn[R], selection: Selection) -> None:
        super().__init__("pictures", selection)
        self._folder, self._drawn = folder, drawn
        folder.mkdir(parents=True)

    def write(self, outcome: Outcome[R]) -> None:
        """Write the picture of a result."""
        write_bytes(self._folder / f"{outcome.number:06d}.png", self._drawn.png(outcome))


class Moment(NamedTuple):
    """A picture for the page."""

    seconds: float
    """Since the first result."""
    png: bytes


class Moments[R](Writer[R]):
    """Keeps pictures from all over a recording, for the page.

    Attributes:
        kept: The pictures.
    """

    MOST = 9

    def __init__(self, drawn: Drawn[R], ticks: int) -> None:
        """Keep none yet.

        Args:
            drawn: What draws them.
            ticks: Of the recording.
        """
        super().__init__("moments", Selection(max(1, ticks // self.MOST), self.MOST))
        self._drawn = drawn
        self.kept: list[Moment] = []

    def write(self, outcome: Outcome[R]) -> None:
        """Keep a result's picture."""
        self.kept.append(Moment(outcome.seconds, self._drawn.png(outcome)))


def png_bytes(sheet: UInt8[Array, "h w 3"]) -> bytes:
    """A picture as PNG."""
    _, content = cv2.imencode(".png", sheet)
    return content.tobytes()
