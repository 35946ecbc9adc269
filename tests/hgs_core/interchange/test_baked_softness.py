"""Baked splats, drawn without antialiasing, against the antialiased picture at the size of training."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
import torch
from torch.nn.functional import avg_pool2d

from hgs_core.interchange.baked_softness import with_baked_softness
from hgs_core.metrics.psnr import psnr
from hgs_core.render.rasterize import rasterize
from hgs_core.scene.camera import Camera
from hgs_core.scene.splats import HybridScene, Segment
from tests.synthetic import ring_of_cameras, synthetic_scene

RIG = ring_of_cameras(4, 64, 48)


@pytest.fixture(scope="module")
def thin() -> HybridScene[np.ndarray]:
    """The synthetic figure with splats of an eighth of their width."""
    static, dynamic = (splats.map(lambda array: array.numpy()) for splats in synthetic_scene())
    static, dynamic = (
        dataclasses.replace(splats, log_scales=splats.log_scales - np.float32(np.log(8)))
        for splats in (static, dynamic)
    )
    return HybridScene(static, (Segment(0.0, 1.0, dynamic),), antialiased=True)


def picture(scene: HybridScene[np.ndarray], camera: Camera, times: int) -> torch.Tensor:
    tensors = scene.map(torch.from_numpy)
    render = rasterize(
        tensors.static,
        tensors.segments[0].dynamic,
        camera.scaled(times),
        0.5,
        gradients="none",
        antialiased=scene.antialiased,
    )
    return avg_pool2d(render.rgb.clamp(0, 1)[None], times)[0]


@pytest.mark.parametrize("times", [1, 2, 4])
def test_a_viewer_without_antialiasing_comes_nearer_to_the_training_pictures(
    thin: HybridScene[np.ndarray], times: int
) -> None:
    baked = with_baked_softness(thin, RIG)
    assert not baked.antialiased
    unbaked = dataclasses.replace(thin, antialiased=False)
    for camera in RIG:
        truth = picture(thin, camera, 1)
        assert psnr(picture(baked, camera, times), truth) > psnr(picture(unbaked, camera, times), truth) + 3


def test_a_splat_that_no_camera_shows_stays_as_it_is(thin: HybridScene[np.ndarray]) -> None:
    means = thin.static.means.copy()
    means[0] = (0, 1000, 0)
    scene = dataclasses.replace(thin, static=dataclasses.replace(thin.static, means=means))
    baked = with_baked_softness(scene, RIG).static
    np.testing.assert_allclose(baked.log_scales[0], scene.static.log_scales[0], rtol=1e-6)
    np.testing.assert_allclose(baked.opacity_logits[0], scene.static.opacity_logits[0], atol=1e-4)
    assert (baked.log_scales[1:] > scene.static.log_scales[1:]).all()


def test_splats_trained_without_antialiasing_keep_their_opacities(thin: HybridScene[np.ndarray]) -> None:
    plain = dataclasses.replace(thin, antialiased=False)
    np.testing.assert_array_equal(with_baked_softness(plain, RIG).static.opacity_logits, plain.static.opacity_logits)
