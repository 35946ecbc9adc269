from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from hgs_core.capture.picture import read_mask, read_picture
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
