"""No renderer mirrors the scene."""

from __future__ import annotations

import pytest
import torch

from hgs_core.render import rasterize
from tests.chirality import assert_not_mirrored, letters, views
from tests.hgs_core.render.comparison import every_backend


@every_backend
@pytest.mark.parametrize("view", [0, 1], ids=["front", "above"])
@pytest.mark.parametrize("moving", [False, True], ids=["still", "moving"])
def test_letters_are_not_mirrored(backend: str, view: int, moving: bool) -> None:
    scene = letters(moving=moving).map(torch.from_numpy)
    camera = views(192, 144)[view]
    render = rasterize(
        scene.static, scene.segments[0].dynamic, camera, 0.5, backend=backend, gradients="none", antialiased=True
    )
    assert_not_mirrored(render.rgb.permute(1, 2, 0).numpy(), camera)
