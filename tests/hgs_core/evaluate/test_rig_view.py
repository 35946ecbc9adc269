"""A picture as the rig shows it against a pixel computed by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
import torch

from hgs_core.evaluate.rig_view import RigView
from hgs_core.scene.camera import Camera

CAMERA = Camera("a", 9, 6, 8.0, 8.0, 4.1, 3.2, np.eye(4))
COLOUR_MAP = [[0.9, 0.05, 0.0, 0.02], [0.0, 1.1, 0.0, -0.03], [0.1, 0.0, 1.0, 0.01]]
PICTURE = torch.rand(3, 6, 9, generator=torch.Generator().manual_seed(0))


def test_a_pixel_is_darkened_then_mapped() -> None:
    rig = RigView([-0.3, 0.1], COLOUR_MAP, CAMERA)
    r = math.hypot(7 + 0.5 - 4.1, 1 + 0.5 - 3.2) / (math.hypot(9, 6) / 2)
    dark = PICTURE[:, 1, 7].double().numpy() * (1 - 0.3 * r**2 + 0.1 * r**4)
    assert rig.darkened(PICTURE)[:, 1, 7].tolist() == pytest.approx(dark, abs=1e-6)
    assert rig.shown(PICTURE)[:, 1, 7].tolist() == pytest.approx(np.array(COLOUR_MAP) @ [*dark, 1.0], abs=1e-6)


def test_without_a_colour_map_the_rig_shows_the_lens_alone() -> None:
    rig = RigView([-0.3, 0.1], None, CAMERA)
    assert torch.equal(rig.shown(PICTURE), rig.darkened(PICTURE))


def test_the_rig_shows_no_colour_beyond_those_of_a_picture() -> None:
    bright = [[3.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, -2.0], [0.0, 0.0, 1.0, 0.0]]
    shown = RigView([0.0, 0.0], bright, CAMERA).shown(torch.full((3, 6, 9), 0.5))
    assert torch.equal(shown[:, 0, 0], torch.tensor([1.0, 0.0, 0.5]))
