"""Tile lists and blending against a look at every tile, splat and pixel."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
import torch

from hgs_core.render import compositing
from hgs_core.render.compositing import blend, composite, tile_lists
from hgs_core.render.projection import Ellipses
from tests.tolerances import assert_close

WIDTH, HEIGHT = 70, 40  # 5 tiles across and 3 down, the last ones cut
ACROSS, DOWN = 5, 3


def ellipses(count: int = 40, seed: int = 0) -> Ellipses:
    """Discs of 1 to 12 pixels' deviation in and around the picture, some at equal depths."""
    r = np.random.default_rng(seed)
    deviations = torch.tensor(r.uniform(1, 12, count))
    factors = torch.stack([1 / deviations, torch.zeros(count).double(), 1 / deviations], 1)
    opacities = torch.tensor(r.uniform(0.1, 1, count))
    opacities[::2] = 1  # so that pixels are finished before their lists are
    reach = deviations * torch.sqrt(2 * torch.log(255 * opacities))
    means = r.uniform((5, 5), (WIDTH - 5, HEIGHT - 5), (count, 2))
    means[::2] = 35, 20  # one behind the other
    return Ellipses(
        index=torch.arange(count),
        means=torch.tensor(means),
        factors=factors,
        half_sizes=torch.stack([reach, reach], 1),
        depths=torch.tensor(r.integers(1, 8, count).astype(np.float64)),
        opacities=opacities,
        rgb=torch.tensor(r.uniform(size=(count, 3))),
    )


def listed(given: Ellipses, tile: int) -> list[int]:
    """The ellipses with a box that reaches a tile, nearest first, ties in the order of their rows."""
    x, y = 16 * (tile % ACROSS), 16 * (tile // ACROSS)
    found = []
    for row in range(len(given.depths)):
        (mx, my), (hx, hy) = given.means[row].tolist(), given.half_sizes[row].tolist()
        if mx - hx < x + 16 and mx + hx >= x and my - hy < y + 16 and my + hy >= y:
            found.append(row)
    return sorted(found, key=lambda row: float(given.depths[row]))


def test_every_tile_lists_what_reaches_it_by_depth() -> None:
    given = ellipses()
    rows, starts = tile_lists(given, WIDTH, HEIGHT, None)
    assert len(starts) == ACROSS * DOWN + 1
    for tile in range(ACROSS * DOWN):
        assert rows[starts[tile] : starts[tile + 1]].tolist() == listed(given, tile)


def test_masked_tiles_list_nothing_and_the_others_the_same() -> None:
    given, mask = ellipses(), torch.ones(DOWN, ACROSS, dtype=torch.bool)
    mask[1, 2] = mask[0, 0] = False
    rows, starts = tile_lists(given, WIDTH, HEIGHT, mask)
    for tile in range(ACROSS * DOWN):
        expected = listed(given, tile) if mask.reshape(-1)[tile] else []
        assert rows[starts[tile] : starts[tile + 1]].tolist() == expected


def test_more_entries_than_can_be_counted_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compositing, "ENTRIES_MAX", 10)
    with pytest.raises(RuntimeError, match="render fewer, smaller or less"):
        tile_lists(ellipses(), WIDTH, HEIGHT, None)


def drawn_one_by_one(given: Ellipses) -> np.ndarray:
    """Colour, coverage and depth [5, H, W], one pixel and one splat at a time (docs/numerics.md, "Compositing")."""
    order = sorted(range(len(given.depths)), key=lambda row: float(given.depths[row]))
    image = np.zeros((5, HEIGHT, WIDTH))
    for y in range(HEIGHT):
        for x in range(WIDTH):
            passed = 1.0
            for row in order:
                dx, dy = x + 0.5 - float(given.means[row, 0]), y + 0.5 - float(given.means[row, 1])
                distance = (dx * dx + dy * dy) * float(given.factors[row, 0]) ** 2
                alpha = min(0.99, float(given.opacities[row]) * math.exp(-0.5 * distance))
                if alpha < 1 / 255:
                    continue
                if passed * (1 - alpha) <= 1e-4:
                    break
                values = [*given.rgb[row].tolist(), 1.0, float(given.depths[row])]
                image[:, y, x] += passed * alpha * np.array(values)
                passed *= 1 - alpha
    return image


@pytest.mark.parametrize("most", [2_000_000, 1])
def test_the_picture_is_that_of_pixel_after_pixel(monkeypatch: pytest.MonkeyPatch, most: int) -> None:
    """Whether many tiles are computed together or each alone."""
    monkeypatch.setattr(compositing, "_BATCH", most)
    given = ellipses(25)
    image = composite(given, WIDTH, HEIGHT, None, torch.float64, depth=True)
    np.testing.assert_allclose(image.numpy(), drawn_one_by_one(given), atol=1e-12)


def test_every_tile_with_splats_is_blended_once() -> None:
    tiles = torch.cat([batch.tiles for batch in blend(ellipses(5), WIDTH, HEIGHT, None, torch.float64)])
    expected = [tile for tile in range(ACROSS * DOWN) if listed(ellipses(5), tile)]
    assert sorted(tiles.tolist()) == expected


def test_weights_add_up_to_the_coverage() -> None:
    for batch in blend(ellipses(), WIDTH, HEIGHT, None, torch.float64):
        torch.testing.assert_close(batch.weights.sum(1), batch.coverage, rtol=0, atol=1e-12)


def test_a_picture_without_splats_is_empty_and_has_a_derivative() -> None:
    none = ellipses(0)
    none.rgb.requires_grad_()
    image = composite(none, WIDTH, HEIGHT, None, torch.float32, depth=False)
    assert image.shape == (4, HEIGHT, WIDTH)
    assert not image.any()
    assert image.requires_grad


def test_pulls_are_sums_of_the_magnitudes_of_every_pixels_gradient() -> None:
    given, whole = ellipses(12), torch.zeros(12, 2, dtype=torch.float64)
    needles = dataclasses.replace(given, factors=given.factors + torch.tensor([0.0, 0.3, 0.0]))
    means = needles.means.requires_grad_()
    weights = torch.randn((4, HEIGHT, WIDTH), generator=torch.Generator().manual_seed(1), dtype=torch.float64)
    image = composite(needles, WIDTH, HEIGHT, None, torch.float64, depth=False)
    expected = torch.zeros_like(whole)
    for loss in (image * weights).sum(0).flatten()[::7]:
        expected += torch.autograd.grad(loss, means, retain_graph=True)[0].abs()
    every_seventh = torch.zeros(WIDTH * HEIGHT, dtype=torch.float64)
    every_seventh[::7] = 1
    drawn = composite(needles, WIDTH, HEIGHT, None, torch.float64, depth=False, pulls=whole)
    (drawn * weights * every_seventh.view(HEIGHT, WIDTH)).sum().backward()
    assert (expected > 0).any(1).sum() > 6
    assert_close(whole.numpy(), expected.numpy(), "pulls")
