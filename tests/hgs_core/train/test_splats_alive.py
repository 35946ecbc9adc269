"""The splats of a moment: without the others, pictures and their gradients are the same."""

from __future__ import annotations

import numpy as np
import torch

from hgs_core.render import rasterize
from hgs_core.scene.temporal import evaluate
from hgs_core.train.splats_alive import living_rows, rows_taken
from tests.hgs_core.render.scenes import camera, dynamic_splats


def test_all_that_can_be_drawn_is_there_and_little_else() -> None:
    splats = dynamic_splats(400, dtype=torch.float32)
    splats.time_log_precisions[:] = torch.linspace(-40, 90, 400)
    splats.opacity_logits[::7] = -8.0
    for moment in (0.0, 0.37, 1.0):
        opacities = evaluate(splats.map(lambda array: array.numpy()), moment)[2]
        rows = living_rows(splats, moment).numpy()
        drawn = np.flatnonzero(opacities >= 1 / 255)
        assert set(drawn) <= set(rows.tolist())
        assert (opacities[rows] >= 0.98 / 255).all()
        assert 0 < len(rows) < 400
        assert (np.diff(rows) > 0).all()


def test_a_picture_of_the_living_is_the_picture() -> None:
    splats = dynamic_splats(300, dtype=torch.float32)
    splats.time_log_precisions[:] = 5.0
    rows = living_rows(splats, 0.4)
    assert len(rows) < 300
    every, living = (
        rasterize(None, chosen, camera(75, 41), 0.4, gradients="none") for chosen in (splats, rows_taken(splats, rows))
    )
    assert every.alpha.any()
    assert torch.equal(every.rgb, living.rgb)
    assert torch.equal(every.alpha, living.alpha)


def test_rows_that_are_taken_are_copies() -> None:
    splats = dynamic_splats(5, dtype=torch.float32)
    taken = rows_taken(splats, torch.tensor([1, 4]))
    for name, array in taken.items():
        assert torch.equal(array, getattr(splats, name)[[1, 4]])
    taken.rgb[:] = 7
    assert not (splats.rgb == 7).any()
