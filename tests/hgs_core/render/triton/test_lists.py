"""Lists of the tiles against those of the float64 reference, which go by a splat's box."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from hgs_core.render.compositing import blend
from hgs_core.render.moment import moment_of_static
from hgs_core.render.projection import project as project_reference
from hgs_core.render.triton.lists import list_by_tile
from hgs_core.render.triton.screen import project
from tests.hgs_core.render.scenes import static_splats
from tests.hgs_core.render.triton.small import view
from tests.interpreted_triton import DEVICE

LANE = torch.arange(256, device=DEVICE)
MASK = np.array([[True, False, True], [True, True, False]])


@pytest.mark.parametrize("mask", [None, MASK])
def test_every_tile_lists_all_that_can_be_seen_in_it_by_depth(mask: np.ndarray | None) -> None:
    seen = view(40, 30, tile_mask=mask)
    static = static_splats(60).map(lambda array: array.float().to(DEVICE))
    lists = list_by_tile(project(static, None, seen, torch.device(DEVICE)), seen)
    assert lists is not None
    ellipses = project_reference(moment_of_static(static), seen.camera)
    depths = dict(zip(ellipses.index.tolist(), ellipses.depths.float().tolist(), strict=True))
    reached = {tile: set[int]() for tile in range(6)}
    masked = None if mask is None else torch.from_numpy(mask).to(DEVICE)
    for batch in blend(ellipses, 40, 30, masked, torch.float64):
        for tile, rows, weights in zip(batch.tiles.tolist(), batch.rows, batch.weights, strict=True):
            x, y = 16 * (tile % 3) + LANE % 16, 16 * (tile // 3) + LANE // 16
            inside = weights[:, (x < 40) & (y < 30)]  # a tile at the edge
            reached[tile] |= set(ellipses.index[rows[inside.amax(1) > 0]].tolist())
    for tile, (begin, end) in enumerate(lists.ranges.tolist()):
        listed = lists.splats[begin:end].tolist()
        assert reached[tile] <= set(listed) <= set(depths)
        assert len(set(listed)) == len(listed)
        assert [depths[row] for row in listed] == sorted(depths[row] for row in listed)
        if mask is not None and not mask.reshape(-1)[tile]:
            assert listed == []
    assert lists.entries_static == len(lists.splats) == int(lists.counts.sum())
    assert lists.entries_dynamic == 0


def test_a_parameter_that_is_not_finite_leaves_no_lists() -> None:
    static = static_splats(20).map(lambda array: array.float().to(DEVICE))
    static.rgb[7, 1] = torch.nan
    assert list_by_tile(project(static, None, view(), torch.device(DEVICE)), view()) is None
