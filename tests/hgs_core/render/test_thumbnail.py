"""The picture in a list of scenes against the reference rasterizer's."""

from __future__ import annotations

import io
from dataclasses import replace

import numpy as np
import pytest
import torch
from PIL import Image

from hgs_core.render import rasterize
from hgs_core.render.thumbnail import thumbnail
from hgs_core.scene import HybridScene, Segment
from tests.hgs_core.render.scenes import camera, dynamic_splats, static_splats

VIEW = camera(96, 64)
SCENE = HybridScene(
    static_splats(20, dtype=torch.float32).map(torch.Tensor.numpy),
    (Segment(2.0, 4.0, dynamic_splats(40, dtype=torch.float32).map(torch.Tensor.numpy)),),
    background=(0.2, 0.5, 0.9),
)


def decoded(jpeg: bytes) -> np.ndarray:
    with Image.open(io.BytesIO(jpeg)) as image:
        assert image.format == "JPEG"
        return np.asarray(image).astype(np.float64) / 255


def truth(scene: HybridScene[np.ndarray], time: float) -> np.ndarray:
    picture = rasterize(
        scene.static.map(torch.tensor),
        scene.segments[0].dynamic.map(torch.tensor),
        VIEW,
        time,
        background=scene.background,
        antialiased=scene.antialiased,
        backend="reference",
        gradients="none",
    )
    return picture.rgb.clamp(0, 1).permute(1, 2, 0).numpy()


def test_it_shows_the_middle_of_the_scene() -> None:
    shown = decoded(thumbnail(SCENE, VIEW))
    at = {time: float(np.abs(shown - truth(SCENE, time)).mean()) for time in (0.4, 0.5, 0.6)}
    assert at[0.5] < min(0.02, at[0.4], at[0.6])  # 0.02: what JPEG may lose, chiefly of colour at half the size


def test_the_subject_alone_has_nothing_that_stands_still() -> None:
    none = static_splats(0, dtype=torch.float32).map(torch.Tensor.numpy)
    assert thumbnail(SCENE, VIEW, subject_only=True) == thumbnail(replace(SCENE, static=none), VIEW)
    assert thumbnail(SCENE, VIEW, subject_only=True) != thumbnail(SCENE, VIEW)


@pytest.mark.parametrize("antialiased", [False, True])
def test_thin_splats_fade_where_the_scene_is_antialiased(antialiased: bool) -> None:
    """White needles on black: JPEG blurs them, but keeps how bright they are together."""
    needles = static_splats(200, dtype=torch.float32)
    needles.log_scales[:] = -6
    needles.opacity_logits[:] = 6
    needles.rgb[:] = 1
    scene = replace(
        SCENE,
        static=needles.map(torch.Tensor.numpy),
        background=(0.0, 0.0, 0.0),
        antialiased=antialiased,
        segments=(Segment(2.0, 4.0, dynamic_splats(0, dtype=torch.float32).map(torch.Tensor.numpy)),),
    )
    assert decoded(thumbnail(scene, VIEW)).mean() == pytest.approx(truth(scene, 0.5).mean(), abs=0.01)


@pytest.mark.parametrize(("width", "height", "size"), [(960, 640, (480, 320)), (96, 64, (96, 64))])
def test_it_is_at_most_480_pixels_wide(width: int, height: int, size: tuple[int, int]) -> None:
    assert decoded(thumbnail(SCENE, camera(width, height))).shape[:2] == (size[1], size[0])
