"""The first picture of a video or a picture file, against the readers of captures."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from hgs_core.base.errors import InputError
from hgs_core.capture.pictures.first_picture import first_picture
from hgs_core.capture.pictures.video import VideoReader
from tests.conftest import REPOSITORY

VIDEO = REPOSITORY / "samples" / "studio" / "cam00.mp4"


def test_a_video_shows_its_first_frame() -> None:
    expected, _ = VideoReader(VIDEO).read(0, 0)
    found = first_picture(VIDEO)
    assert found.shape == expected.shape
    assert np.abs(found.astype(int) - expected).mean() < 1.5  # levels; chroma is not interpolated here


def test_a_picture_is_upright(tmp_path: Path) -> None:
    turned = Image.Exif()
    turned[0x0112] = 6  # a quarter turn to the right
    Image.new("RGB", (80, 48)).save(tmp_path / "a.jpg", exif=turned)
    assert first_picture(tmp_path / "a.jpg").shape == (80, 48, 3)


@pytest.mark.parametrize("name", ["a.mp4", "a.png"])
def test_a_damaged_file_is_refused(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_bytes(b"no picture")
    with pytest.raises(InputError, match=name):
        first_picture(tmp_path / name)
