"""How a camera's pictures are shown, alike from a recording's first to its last."""

from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np

from navtool.base.note import Note
from navtool.datasets.decode.levels import FULL, Levels
from navtool.datasets.decode.messages import ImageFrame


class Colours(StrEnum):
    """Where red and blue lie in a camera's pictures."""

    auto = "auto"
    """As encodings and formats say."""
    as_held = "as_held"
    """In a compressed picture as the file has them, whatever the message's format says of exchanged ones."""
    exchanged = "exchanged"
    """The other way round than the encoding or the file says."""


@dataclass(frozen=True, slots=True)
class PictureView:
    """Levels of 16-bit pictures, and colours."""

    levels: Levels = FULL
    colours: Colours = Colours.auto

    def shown(self, frame: ImageFrame) -> ImageFrame:
        """The picture at these levels and colours; one that lies outside of the levels is noted."""
        if frame.deep is not None and not self.levels.is_full:
            notes = frame.notes
            if self.levels.outside(frame.deep.samples):
                what = f"parts of pictures are darker than {self.levels.low} or brighter than {self.levels.high}"
                notes = (*notes, Note("image.out-of-range", f"{what}: shown black or white"))
            frame = replace(frame, rgb=frame.deep.rgb(self.levels), notes=notes)
        if self.colours is Colours.exchanged or (self.colours is Colours.as_held and frame.exchanged):
            frame = replace(frame, rgb=np.ascontiguousarray(frame.rgb[..., ::-1]), exchanged=not frame.exchanged)
        return frame


AS_RECORDED = PictureView()
"""All 16 bits, and colours as encodings and formats say."""
