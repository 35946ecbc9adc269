"""Arguments of the kernel; points/test_sweep_costs.py compares its results with numpy's."""

from __future__ import annotations

import numpy as np
import pytest

from hgs_core.native.colour_sweep import colour_descriptors, colour_sweep
from hgs_core.scene.camera import Camera

CAMERA = Camera("one", 8, 6, 8, 8, 4, 3, np.eye(4))
RAYS, OWN = np.zeros((2, 3)), np.zeros((2, 6), np.uint8)


def test_descriptors_are_of_bytes() -> None:
    with pytest.raises(ValueError, match="picture must be a contiguous uint8 array"):
        colour_descriptors(np.zeros((6, 8, 3), np.float32))  # type: ignore[arg-type]


def test_no_rays_have_no_costs() -> None:
    sources = [(CAMERA, np.zeros((48, 6), np.uint8))]
    nothing = colour_sweep(np.zeros(3), RAYS[:0], OWN[:0], np.ones(5), sources, [], hull_share=0.5, blind=60)
    assert nothing.shape == (0, 5)


@pytest.mark.parametrize("wrong", ["descriptors", "mask"])
def test_a_picture_of_another_size_than_its_camera_is_refused(wrong: str) -> None:
    rows = 47 if wrong == "descriptors" else 48
    mask = np.ones((6, 7 if wrong == "mask" else 8), bool)
    with pytest.raises(ValueError, match=f"{wrong} must be"):
        colour_sweep(
            np.zeros(3),
            RAYS,
            OWN,
            np.ones(5),
            [(CAMERA, np.zeros((rows, 6), np.uint8))],
            [(CAMERA, mask)],
            hull_share=0.5,
            blind=60,
        )
