"""A display that was stored is the one that the first frame stated."""

from __future__ import annotations

import dataclasses
import json
from typing import Any

import av
import numpy as np
import pytest

from hgs_core.capture.pictures.frame_display import FrameDisplay, opacity
from hgs_core.capture.pictures.wide_colours import WideColours

PLAIN = FrameDisplay(0, None, transparent=False, seen_through=False)
MIRRORED = FrameDisplay(None, WideColours(18, 9), transparent=True, seen_through=True)


def frame(*levels: int) -> av.VideoFrame:
    """A frame of 16x16 pixels, with these opacities in its columns in turn."""
    picture = np.full((16, 16, 4), 100, np.uint8)
    picture[..., 3] = np.resize(levels, 16)
    return av.VideoFrame.from_ndarray(picture, format="rgba")


@pytest.mark.parametrize("display", [PLAIN, MIRRORED])
def test_a_stored_display_comes_back(display: FrameDisplay) -> None:
    assert FrameDisplay.from_plain(json.loads(json.dumps(dataclasses.asdict(display)))) == display


@pytest.mark.parametrize("field", [field.name for field in dataclasses.fields(FrameDisplay)])
def test_a_display_without_a_field_is_refused(field: str) -> None:
    document: dict[str, Any] = {name: value for name, value in dataclasses.asdict(PLAIN).items() if name != field}
    with pytest.raises(KeyError, match=field):
        FrameDisplay.from_plain(document)


@pytest.mark.parametrize(("levels", "seen_through"), [((255, 255), False), ((255, 254), True), ((0, 0), True)])
def test_frames_that_store_opacities_are_seen_through_where_one_is_less_than_whole(
    levels: tuple[int, ...], seen_through: bool
) -> None:
    display = FrameDisplay.of(frame(*levels), (16, 16))
    assert display == FrameDisplay(0, None, transparent=True, seen_through=seen_through)


def test_frames_without_opacities_are_not_transparent() -> None:
    opaque = av.VideoFrame.from_ndarray(np.zeros((16, 16, 3), np.uint8), format="rgb24")
    assert FrameDisplay.of(opaque, (16, 16)) == PLAIN


def test_opacity_is_that_of_each_pixel() -> None:
    from av.video.reformatter import VideoReformatter

    found = opacity(frame(0, 90, 255), (16, 16), VideoReformatter())
    np.testing.assert_array_equal(found[..., 0], np.tile(np.resize((0, 90, 255), 16), (16, 1)))
