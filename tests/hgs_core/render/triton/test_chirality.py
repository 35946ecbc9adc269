"""The Triton kernels do not mirror the scene either."""

from __future__ import annotations

import torch

from hgs_core.render import rasterize
from tests.chirality import assert_not_mirrored, letters, views


def test_letters_are_not_mirrored() -> None:
    scene = letters(moving=True).map(torch.from_numpy)
    camera = views(32, 24)[1]  # the interpreter is slow
    render = rasterize(scene.static, scene.segments[0].dynamic, camera, 0.5, backend="triton", gradients="none")
    assert_not_mirrored(render.rgb.permute(1, 2, 0).cpu().numpy(), camera)
