"""The codec mirrors nothing."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import torch

from hgs_core.codec import decode_scene, encode_scene
from hgs_core.render import rasterize
from tests.chirality import assert_not_mirrored, letters, views


@pytest.mark.parametrize("moving", [False, True], ids=["still", "moving"])
def test_a_decoded_scene_is_not_mirrored(tmp_path: Path, moving: bool) -> None:
    cameras = views(192, 144)
    encode_scene(letters(moving=moving), tmp_path, cameras=cameras, times=np.linspace(0, 1, 5), title="Letters")
    scene = decode_scene(tmp_path).map(torch.from_numpy)
    for camera in cameras:
        dynamic = scene.segments[0].dynamic
        render = rasterize(scene.static, dynamic, camera, 0.5, backend="reference", gradients="none")
        assert_not_mirrored(render.rgb.permute(1, 2, 0).numpy(), camera)
