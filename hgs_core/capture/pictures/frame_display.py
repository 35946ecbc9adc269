"""The display of a video's frames, as the first of them states it: turns, wide colours, and transparency.

It is kept with the facts in the packets, so that whoever opens the video again need not decode anything.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from hgs_core.capture.pictures.orientation import quarter_turns
from hgs_core.capture.pictures.wide_colours import WideColours, wide_colours_of

if TYPE_CHECKING:
    import av
    from av.video.reformatter import VideoReformatter

__all__ = ["FrameDisplay", "opacity"]


@dataclass(frozen=True)
class FrameDisplay:
    """The display of the frames of one video."""

    turns: int | None  # quarter turns to the left, 0 to 3, until frames are upright; None: mirrored or tilted
    wide_colours: WideColours | None  # None: ordinary ones
    transparent: bool  # whether frames store opacities
    seen_through: bool  # whether a pixel of the first frame is not opaque

    @staticmethod
    def of(frame: av.VideoFrame, size: tuple[int, int]) -> FrameDisplay:
        """Return the display that a video's first frame states; `size` is its stored width and height."""
        from av.video.reformatter import VideoReformatter

        transparent = any(component.is_alpha for component in frame.format.components)
        seen_through = transparent and bool(opacity(frame, size, VideoReformatter()).min() < 255)
        return FrameDisplay(quarter_turns(frame), wide_colours_of(frame), transparent, seen_through)

    @staticmethod
    def from_plain(document: dict[str, Any]) -> FrameDisplay:
        """Return the display of a stored `dataclasses.asdict`.

        Raises:
            KeyError: a field is missing.
            TypeError: a field has another type.
        """
        wide = document["wide_colours"]
        return FrameDisplay(
            document["turns"],
            None if wide is None else WideColours(**wide),
            document["transparent"],
            document["seen_through"],
        )


def opacity(frame: av.VideoFrame, size: tuple[int, int], reformatter: VideoReformatter) -> npt.NDArray[np.uint16]:
    """Return the opacity of a frame's pixels [H, W, 1], 0..255, at a width and height."""
    deep = reformatter.reformat(frame, *size, "rgba", threads=1)
    return np.asarray(deep.to_ndarray()[..., 3:], np.uint16)
