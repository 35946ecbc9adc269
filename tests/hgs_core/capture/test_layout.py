"""What is told of a capture without decoding it, beside what opening it finds."""

from __future__ import annotations

from pathlib import Path

import pytest

from hgs_core.base.errors import InputError
from hgs_core.capture.layout import Layout, Outline
from hgs_core.capture.n3dv import N3DV
from hgs_core.capture.open import open_capture
from hgs_core.capture.panoptic import PANOPTIC_SPORTS
from hgs_core.capture.transforms import NERFSTUDIO
from tests.hgs_core.capture.conftest import SAMPLE
from tests.hgs_core.capture.test_transforms import photographs  # noqa: F401 - a fixture


def assert_outlined(layout: Layout, path: Path) -> Outline:
    outline, capture = layout.outline(path), open_capture(path)
    assert outline.cameras == tuple(camera.name for camera in capture.cameras)
    assert outline.frames == len(capture.times)
    return outline


def test_videos_are_outlined_by_their_names_and_the_first_header() -> None:
    assert assert_outlined(N3DV, SAMPLE).seconds == 2.0


def test_a_panoptic_capture_is_outlined_by_its_table(panoptic: Path) -> None:
    assert assert_outlined(PANOPTIC_SPORTS, panoptic).seconds == pytest.approx(6 / 30)


def test_photographs_are_outlined_by_what_is_there(photographs: Path) -> None:  # noqa: F811
    next((photographs / "images").iterdir()).unlink()
    assert assert_outlined(NERFSTUDIO, photographs).seconds == 0.0


def test_poses_without_videos_have_no_length(n3dv: Path) -> None:
    for video in n3dv.glob("*.mp4"):
        video.unlink()
    assert N3DV.outline(n3dv) == Outline(())


@pytest.mark.parametrize("content", [b"", b"no video"])
def test_a_damaged_video_is_named(n3dv: Path, content: bytes) -> None:
    first = min(n3dv.glob("*.mp4"))
    first.write_bytes(content)
    with pytest.raises(InputError, match=rf"{first.name}: the video is unreadable"):
        N3DV.outline(n3dv)
