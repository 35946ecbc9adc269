from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from hgs_core.base.errors import InputError
from hgs_core.capture.pictures.picture import list_folder, list_folders, read_mask, read_picture, read_sized_picture
from hgs_core.scene.camera import Camera

CAMERA = Camera("a", 4, 3, 5, 5, 2, 1.5, np.eye(4))


@pytest.mark.parametrize("mode", ["1", "L", "I;16", "RGB", "RGBA", "LA"])
def test_masks_of_every_mode_mean_the_same(tmp_path: Path, mode: str) -> None:
    truth = np.zeros((3, 4), bool)
    truth[1, 2] = True
    if mode == "I;16":
        image = Image.fromarray(truth.astype(np.uint16) * 300)
    else:
        image = Image.fromarray(truth.astype(np.uint8) * 255).convert(mode)
    image.save(tmp_path / "mask.png")
    np.testing.assert_array_equal(read_mask(tmp_path / "mask.png", CAMERA), truth)


def test_grey_pictures_become_colour(tmp_path: Path) -> None:
    Image.new("L", (4, 3), 77).save(tmp_path / "picture.png")
    np.testing.assert_array_equal(read_picture(tmp_path / "picture.png", CAMERA), np.full((3, 4, 3), 77))


def test_grey_of_16_bits_keeps_its_levels(tmp_path: Path) -> None:
    levels = np.array([[0, 257 * 100, 65535]], np.uint16)
    Image.fromarray(levels).save(tmp_path / "a.png")
    camera = Camera("a", 3, 1, 50.0, 50.0, 1.5, 0.5, np.eye(4))
    assert read_picture(tmp_path / "a.png", camera)[0].tolist() == [[0] * 3, [100] * 3, [255] * 3]


def test_a_link_to_itself_is_named(tmp_path: Path) -> None:
    (tmp_path / "loop.mp4").symlink_to("loop.mp4")
    with pytest.raises(InputError, match=r"loop\.mp4: cannot be read"):
        list_folder(tmp_path)


def test_folders_are_listed_without_hidden_ones(tmp_path: Path) -> None:
    for name in ("b", ".a", "c"):
        (tmp_path / name).mkdir()
    (tmp_path / "file").touch()
    assert list_folders(tmp_path) == ["b", "c"]
    assert list_folders(tmp_path / "gone") == []


def test_files_are_listed_without_hidden_ones(tmp_path: Path) -> None:
    for name in ("1.png", "._1.png", ".DS_Store"):
        (tmp_path / name).touch()
    assert list_folder(tmp_path) == {"1.png": 0}


def test_floating_point_pictures_are_refused_with_the_cure(tmp_path: Path) -> None:
    Image.fromarray(np.full((4, 4), 0.5, np.float32)).save(tmp_path / "a.tiff")
    with pytest.raises(InputError, match=r"floating-point values.*store 16 bits"):
        read_sized_picture(tmp_path / "a.tiff", (4, 4))
