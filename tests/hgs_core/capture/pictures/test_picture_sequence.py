"""Frames as image files; test_layout.py reads them through captures."""

from __future__ import annotations

from pathlib import Path

import pytest
from PIL import Image

from hgs_core.base.errors import InputError
from hgs_core.capture.pictures.picture_sequence import PictureSequence


@pytest.fixture
def pictures(tmp_path: Path) -> list[Path]:
    paths = [tmp_path / f"{frame}.png" for frame in range(3)]
    for frame, path in enumerate(paths):
        Image.new("RGB", (8, 6), (50 * frame,) * 3).save(path)
    return paths


def test_frames_are_read_by_number(pictures: list[Path]) -> None:
    sequence = PictureSequence("a", pictures)
    assert (len(sequence), sequence.width, sequence.height) == (3, 8, 6)
    assert sequence.read(2, 5)[0][0, 0].tolist() == [100, 100, 100]
    assert sequence.files == [(path, path.stat().st_size) for path in pictures]


def test_a_picture_of_another_size_than_most_is_named(pictures: list[Path]) -> None:
    Image.new("RGB", (4, 3)).save(pictures[0])
    with pytest.raises(InputError, match=r"0\.png: the picture is 4x3; other pictures of camera a have 8x6"):
        PictureSequence("a", pictures)


def test_missing_and_empty_files_are_named(pictures: list[Path]) -> None:
    pictures[1].write_bytes(b"")
    with pytest.raises(InputError, match=r"1\.png: the file is empty"):
        PictureSequence("a", pictures)
    pictures[1].unlink()
    with pytest.raises(InputError, match=r"1\.png: camera a has no picture for frame 1"):
        PictureSequence("a", pictures)
