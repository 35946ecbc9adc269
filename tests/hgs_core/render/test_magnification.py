"""The magnification of a view, and pictures that keep their bits where nothing is magnified."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
import torch

from hgs_core.render import rasterize
from hgs_core.render.fixed_view import FixedView
from hgs_core.render.magnification import magnification
from hgs_core.scene.camera import Camera, looking_at
from tests.hgs_core.render.comparison import every_backend
from tests.hgs_core.render.scenes import camera, dynamic_splats, static_splats


def at(x: float, z: float, focal: float = 100.0) -> Camera:
    """A camera of 64 x 64 pixels that looks at the origin."""
    return Camera("camera", 64, 64, focal, focal, 32, 32, looking_at((x, 0, z), (0, 0, 0)))


def times(view: Camera, rig: list[Camera], point: tuple[float, float, float]) -> float:
    """The magnification of a point of the world."""
    local = view.world_to_camera @ (*point, 1.0)
    return float(magnification(view, rig) @ local / local[2])


RIG = [at(-2.0, -3.0), at(0.5, -4.0, 150.0), at(3.0, -2.0)]


@pytest.mark.parametrize("index", [0, 1, 2])
@pytest.mark.parametrize("size", [0.5, 1, 3])
def test_a_view_from_a_camera_is_magnified_by_its_size_everywhere(index: int, size: float) -> None:
    view = RIG[index].scaled(size)
    for point in ((0.0, 0.0, 0.0), (0.3, -0.2, 0.5), (0.0, 0.0, 40.0)):
        assert times(view, RIG, point) == pytest.approx(size, rel=1e-3)
        assert times(view, RIG, point) < size


def test_half_way_to_a_thing_it_is_twice_as_large_and_what_lies_far_behind_is_not() -> None:
    near = at(0.0, -2.0)
    assert times(near, [at(0.0, -4.0)], (0.0, 0.0, 0.0)) == pytest.approx(2, rel=1e-3)
    assert times(near, [at(0.0, -4.0)], (0.0, 0.0, 1000.0)) == pytest.approx(1, rel=1e-2)


def test_between_cameras_it_lies_between_theirs() -> None:
    far, close = at(-0.1, -4.0), at(0.1, -2.0)
    alone = [times(at(0.0, -3.0), [other], (0.0, 0.0, 0.0)) for other in (far, close)]
    assert alone[1] < times(at(0.0, -3.0), [far, close], (0.0, 0.0, 0.0)) < alone[0]


def test_a_turn_of_the_view_moves_it_without_a_jump() -> None:
    def seen(x: float) -> float:
        return times(at(x, -3.0), RIG, (0.0, 0.0, 0.0))

    steps = np.diff([seen(x) for x in np.linspace(-2, 3, 501)])
    assert np.abs(steps).max() < 0.02


def test_cameras_in_one_place_count_alike() -> None:
    assert times(at(0.0, -2.0), [at(0.0, -4.0), at(0.0, -4.0)], (0.0, 0.0, 0.0)) == pytest.approx(2, rel=1e-3)


def test_without_a_rig_nothing_is_magnified() -> None:
    assert not magnification(at(0.0, -1.0), []).any()


@pytest.mark.parametrize("antialiased", [False, True])
@every_backend
def test_a_camera_of_the_rig_shows_the_same_bits(backend: str, antialiased: bool) -> None:
    seen = camera(32, 32)
    static, dynamic = (s.map(torch.Tensor.float) for s in (static_splats(40), dynamic_splats(40)))
    static = dataclasses.replace(static, log_scales=static.log_scales - 2)

    def picture(rig: list[Camera]) -> torch.Tensor:
        return rasterize(
            static, dynamic, seen, 0.4, backend=backend, antialiased=antialiased, gradients="none", rig=rig
        ).rgb

    assert torch.equal(picture([]), picture([seen, at(1.0, -3.0)]))
    assert not torch.equal(picture([]), picture([seen.scaled(0.5)]))


def test_a_fixed_view_draws_what_rasterize_draws() -> None:
    seen = camera(48, 32)
    static, dynamic = (s.map(torch.Tensor.float) for s in (static_splats(60), dynamic_splats(60)))
    rig = [seen.scaled(0.25)]
    view = FixedView(static, seen, backend="cpu", rig=rig)
    for time in (0.2, 0.4):
        expected = rasterize(static, dynamic, seen, time, backend="cpu", rig=rig, gradients="none")
        assert torch.equal(view.frame(dynamic, time).rgb, expected.rgb)


def test_a_magnified_needle_is_as_wide_as_in_the_picture_that_made_it() -> None:
    """A thin line four times magnified has the profile of the small picture, stretched."""
    small = at(0.0, -4.0)
    splat = dataclasses.replace(
        static_splats(1),
        means=torch.zeros(1, 3, dtype=torch.float64),
        quats=torch.tensor([[1.0, 0, 0, 0]], dtype=torch.float64),
        log_scales=torch.tensor([[math.log(0.5), -9.0, -9.0]], dtype=torch.float64),
        opacity_logits=torch.zeros(1, dtype=torch.float64),
    )
    profile = rasterize(splat, None, small.scaled(4), backend="reference", rig=[small]).alpha[:, 128].numpy()
    spread = np.sqrt((profile * (np.arange(256) + 0.5 - 128) ** 2).sum() / profile.sum())
    assert spread == pytest.approx(4 * math.sqrt(0.3), rel=0.05)
