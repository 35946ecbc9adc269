"""The loss of views agrees with independent pictures and formulas, for all pixels and for moving ones."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import torch

from hgs_core.capture.open import open_capture
from hgs_core.fit.encoding_loss import Decibels, Loss
from hgs_core.fit.encoding_views import EncodeViews, views_around
from hgs_core.render.reference import rasterize_reference
from hgs_core.render.types import View
from hgs_core.scene import HybridScene, Segment
from hgs_core.train.targets import target_picture
from tests.synthetic import ring_of_cameras, synthetic_scene, write_capture

TIMES = np.arange(6) / 30
CAMERAS = ring_of_cameras(3, 64, 48)


def scene() -> HybridScene[np.ndarray]:
    static, dynamic = synthetic_scene()
    return HybridScene(static, (Segment(0.0, 5 / 30, dynamic),)).map(lambda tensor: tensor.numpy())


def picture(scene: HybridScene[np.ndarray], camera: int, frame: int) -> torch.Tensor:
    (segment,) = scene.segments
    view = View(CAMERAS[camera], segment.normalised(float(TIMES[frame])), gradients="none")
    tensors = scene.map(torch.from_numpy)
    return rasterize_reference(tensors.static, tensors.segments[0].dynamic, view).rgb.clamp(0, 1)


def mask(camera: int, frame: int) -> torch.Tensor:
    """A box that is larger in later frames; nothing moves in the first."""
    found = torch.zeros(48, 64, dtype=torch.bool)
    found[10 : 10 + 4 * frame, 20 : 20 + 5 * frame + camera] = frame > 0
    return found


def truth(camera: int, frame: int) -> torch.Tensor:
    return (picture(scene(), camera, frame) + 0.02).clamp(0, 1)


VIEWS = EncodeViews("", tuple(CAMERAS), dict(enumerate(CAMERAS)), TIMES, truth, moving=mask)


def test_moving_pixels_of_all_views_are_one_error() -> None:
    given = scene()
    moving = dataclasses.replace(given.segments[0].dynamic, rgb=given.segments[0].dynamic.rgb * 0.8)
    worse = dataclasses.replace(given, segments=(dataclasses.replace(given.segments[0], dynamic=moving),))
    loss = Loss(given, VIEWS, VIEWS.trained)
    sampled = [(i * 3 // 12, int(i * 0.618 % 1 * 6)) for i in range(12)]
    assert any(frame == 0 for _, frame in sampled)
    psnr = []
    for one in (given, worse):
        errors = [((picture(one, *view) - truth(*view)) ** 2)[:, mask(*view)].flatten() for view in sampled]
        psnr.append(-10 * np.log10(float(torch.cat(errors).double().mean())))
    found = loss.of(worse)
    assert found.moving is not None
    np.testing.assert_allclose(found.moving, psnr[0] - psnr[1], rtol=1e-3)
    assert found.moving > 1.2 * found.whole > 0
    assert found.most == found.moving


def test_a_loss_has_the_same_bits_for_any_number_of_torch_threads() -> None:
    given, large = scene(), tuple(ring_of_cameras(3, 640, 480))
    darker = type(given)(dataclasses.replace(given.static, rgb=given.static.rgb * 0.9), given.segments)
    pixels = torch.rand(3, 480, 640, generator=torch.Generator().manual_seed(0))
    moving = torch.rand(480, 640, generator=torch.Generator().manual_seed(1)) < 0.4
    views = EncodeViews(
        "", large, dict(enumerate(large)), TIMES, lambda camera, frame: pixels, moving=lambda camera, frame: moving
    )
    before, found = torch.get_num_threads(), []
    try:
        for threads in (1, 3):
            torch.set_num_threads(threads)
            loss = Loss(given, views, views.trained)
            found.append((loss.of(darker), loss._psnr.tolist()))
    finally:
        torch.set_num_threads(before)
    assert found[0] == found[1]


def test_views_are_drawn_at_the_moments_when_their_pictures_were_taken(tmp_path: Path) -> None:
    cameras = write_capture(tmp_path, frames=3, late={"1": 0.5, "3": 0.5})
    capture, static_and_dynamic = open_capture(tmp_path), synthetic_scene()
    segment = Segment(0.0, 2 / 30, static_and_dynamic[1])
    given = HybridScene(static_and_dynamic[0], (segment,)).map(lambda tensor: tensor.numpy())
    views = EncodeViews(
        "",
        tuple(cameras),
        dict(enumerate(cameras)),
        capture.times,
        lambda camera, frame: target_picture(capture, camera, frame, cameras[camera]),
        capture,
    )
    assert Loss(given, views, {1: cameras[1]})._psnr.min() > 41


def test_nothing_is_said_of_what_moves_where_nothing_tells_or_nothing_does() -> None:
    given = scene()
    for views in (
        dataclasses.replace(VIEWS, moving=None),
        dataclasses.replace(VIEWS, moving=lambda camera, frame: torch.zeros(48, 64, dtype=torch.bool)),
    ):
        assert Loss(given, views, views.trained).of(given) == Decibels(0, None)


def test_masks_are_asked_for_of_trained_cameras_alone() -> None:
    given = scene()
    views = dataclasses.replace(VIEWS, trained={0: CAMERAS[0], 1: CAMERAS[1]})
    assert Loss(given, views, {2: CAMERAS[2]}).of(given).moving is None
    assert Loss(given, views, views.trained).of(given).moving == 0


def test_a_gain_of_the_exact_scene_is_not_for_the_codes_to_spend() -> None:
    lost = Decibels(0.05, -0.02)
    assert lost.without_gain(Decibels(-0.1, -0.3)) == Decibels(0.05 + 0.1, -0.02 + 0.3)
    assert lost.without_gain(Decibels(0.1, 0.3)) == lost
    assert Decibels(0.05, None).without_gain(Decibels(-0.1, None)).most == 0.05 + 0.1


def test_without_pictures_the_scene_itself_is_what_is_compared_with() -> None:
    given = scene()
    views = views_around(given, "cloud")
    loss = Loss(given, views, views.trained)
    assert loss.of(given) == Decibels(0, None)
    darker = type(given)(dataclasses.replace(given.static, rgb=given.static.rgb * 0.9), given.segments)
    assert 0.1 < loss.of(darker).whole < 10


def test_without_pictures_a_loss_shows_on_any_background() -> None:
    """Black splats before nothing do not show on black."""
    given = scene()
    black = type(given)(dataclasses.replace(given.static, rgb=np.zeros_like(given.static.rgb)), given.segments)
    views = views_around(black, "cloud")
    loss = Loss(black, views, views.trained)
    assert loss.of(black) == Decibels(0, None)
    fewer = type(given)(black.static.take(slice(0, 75)), given.segments)
    assert loss.of(fewer).whole > 3
