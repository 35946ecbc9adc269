"""Which tiles a dynamic set touches, against the picture it draws."""

from __future__ import annotations

import dataclasses

import numpy as np
import torch

from hgs_core.render.reference import rasterize_reference
from hgs_core.render.tiles import pixels_to_tiles, tiles_of_dynamic, tiles_to_pixels
from hgs_core.render.types import View
from hgs_core.scene import DynamicSplats
from tests.hgs_core.render.scenes import camera, dynamic_splats


def test_every_pixel_that_a_splat_covers_lies_in_a_touched_tile() -> None:
    view = camera(100, 70)
    splats = dynamic_splats(12)
    small = dataclasses.replace(splats, log_scales=splats.log_scales - 2)
    for time in (0.0, 0.5, 1.0):
        tiles = tiles_of_dynamic(small, view, time)
        covered = rasterize_reference(None, small, View(view, time)).alpha.numpy() > 0
        assert tiles.shape == (5, 7)
        assert not (covered & ~tiles_to_pixels(tiles, 100, 70)).any()
        assert not tiles.all()


def test_a_dead_or_empty_set_touches_nothing() -> None:
    view = camera()
    dead = dataclasses.replace(dynamic_splats(5), time_log_precisions=torch.full((5,), 20.0, dtype=torch.float64))
    empty = DynamicSplats.empty().map(torch.from_numpy)
    assert not tiles_of_dynamic(dead, view, 5.0).any()
    assert not tiles_of_dynamic(empty, view, 0.5).any()


def test_tiles_cover_their_pixels() -> None:
    tiles = np.array([[True, False], [False, True]])
    pixels = tiles_to_pixels(tiles, 20, 18)
    assert pixels.shape == (18, 20)
    assert pixels[15, 15]
    assert not pixels[15, 16]
    assert pixels[17, 19]


def test_a_tile_counts_if_any_of_its_pixels_does_at_the_edge_too() -> None:
    pixels = np.zeros((50, 75), np.bool_)
    pixels[17, 40] = pixels[49, 74] = True
    assert np.argwhere(pixels_to_tiles(pixels)).tolist() == [[1, 2], [3, 4]]
    assert pixels_to_tiles(pixels).shape == (4, 5)
