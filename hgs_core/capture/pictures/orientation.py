"""How a decoded picture is turned to be upright: the display matrix that cameras held on their side write."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, cast

import numpy as np

if TYPE_CHECKING:
    import av
    from av.buffer import Buffer

__all__ = ["quarter_turns"]

# By the signs of (a, b, c, d): the picture's x axis points along (a, b) when it is shown, its y axis along (c, d).
_TURNS = {(1, 0, 0, 1): 0, (0, -1, 1, 0): 1, (-1, 0, 0, -1): 2, (0, 1, -1, 0): 3}


def quarter_turns(frame: av.VideoFrame) -> int | None:
    """Return the quarter turns to the left, 0 to 3, that bring a frame upright; None: it is to be mirrored or tilted.

    A frame without a display matrix is upright.
    """
    side_data = cast("Mapping[str, Buffer]", frame.side_data)  # PyAV's own annotation lacks this kind
    if "DISPLAYMATRIX" not in side_data:
        return 0
    a, b, _, c, d = np.sign(np.frombuffer(bytes(side_data["DISPLAYMATRIX"]), np.int32)[:5]).tolist()
    return _TURNS.get((a, b, c, d))
