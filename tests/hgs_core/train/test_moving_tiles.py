"""Tiles of motion, and the loss in them against the loss of whole pictures."""

from __future__ import annotations

import numpy as np
import torch

from hgs_core.scene.camera import Camera
from hgs_core.train.colour_correction import CameraColours
from hgs_core.train.loss import photometric_loss
from hgs_core.train.moving_tiles import loss_gradient, tiles_of
from tests.tolerances import assert_close


def moving_pixels() -> np.ndarray:  # type: ignore[type-arg]
    """In a picture of 50 x 75 pixels: one pixel in the tile (1, 2), and two in the last one, which is cut."""
    mask = np.zeros((50, 75), np.bool_)
    mask[17, 40] = True
    mask[48:, 74] = True
    return mask


def test_a_tile_moves_if_any_of_its_pixels_does() -> None:
    found = tiles_of(moving_pixels())
    assert found is not None
    assert np.argwhere(found.tiles).tolist() == [[1, 2], [3, 4]]
    assert found.tiles.shape == (4, 5)
    assert found.window == (slice(16, 50), slice(32, 75))


def test_what_moves_apart_falls_into_parts() -> None:
    found = tiles_of(moving_pixels())
    assert found is not None
    one, cut = found.parts
    assert one == (slice(16, 32), slice(32, 48))
    assert cut == (slice(48, 50), slice(64, 75))
    assert found.within(cut) == (slice(32, 34), slice(32, 43))
    assert found.drawn(one).shape == (16, 16)
    assert found.drawn(cut).shape == (2, 11)


def test_parts_are_cut_until_no_row_or_column_of_tiles_is_still() -> None:
    """A ring of tiles cannot be cut and its inside is not drawn; tiles beside it are cut from it, and again."""
    tiles = np.zeros((5, 9), np.bool_)
    tiles[:3, :3] = True
    tiles[1, 1] = False
    tiles[0, 5] = tiles[4, 5] = tiles[4, 8] = True
    found = tiles_of(tiles.repeat(16, 0).repeat(16, 1))
    assert found is not None
    ring, *single = found.parts
    assert ring == (slice(0, 48), slice(0, 48))
    assert not found.drawn(ring)[16:32, 16:32].any()
    assert sorted((rows.start, columns.start) for rows, columns in single) == [(0, 80), (64, 80), (64, 128)]
    assert sum(int(found.drawn(part).sum()) for part in found.parts) == int(tiles.sum()) * 16 * 16


def test_where_nothing_moves_there_are_no_tiles() -> None:
    assert tiles_of(np.zeros((50, 75), np.bool_)) is None


def test_the_gradient_is_that_of_the_picture_with_all_else_perfect() -> None:
    """Reference: the loss by autograd, colours mapped, other tiles replaced by the target: in the parts, and whole.

    The windows of SSIM, which stand on every few pixels, stand elsewhere in the whole picture.
    """
    generator = torch.Generator().manual_seed(0)
    picture, target = (torch.rand(3, 50, 75, generator=generator) for _ in range(2))
    camera = Camera("a", 75, 50, 60.0, 60.0, 37.0, 26.0, np.eye(4))
    affine = torch.eye(3, 4) + 0.1 * torch.randn(3, 4, generator=generator)
    moving = tiles_of(moving_pixels())
    assert moving is not None
    drawn = torch.from_numpy(moving.tiles.repeat(16, 0).repeat(16, 1)[:50, :75].copy())
    for colours in (None, CameraColours(affine, None), CameraColours(affine, torch.tensor([-0.3, 0.1]))):
        whole = picture.clone().requires_grad_(True)
        shown = whole if colours is None else colours.shown(whole, camera)
        photometric_loss(torch.where(drawn, shown, target), target, 0.2).backward()  # type: ignore[no-untyped-call]
        found = loss_gradient(picture, moving.cut(target), camera, moving, 0.2, colours)
        assert whole.grad is not None
        part = picture.clone().requires_grad_(True)
        shown = part if colours is None else colours.shown(part, camera)
        compared = torch.where(drawn, shown, target)
        for rows, columns in moving.parts:
            inside = compared[:, rows, columns], target[:, rows, columns]
            share = inside[1].numel() / target.numel()
            (share * photometric_loss(*inside, 0.2)).backward(retain_graph=True)  # type: ignore[no-untyped-call]
        assert part.grad is not None
        assert_close(found.numpy(), part.grad.numpy(), "gradients")
        assert not found[:, ~drawn].any()
        assert torch.nn.functional.cosine_similarity(found.flatten(), whole.grad.flatten(), dim=0) > 0.98
