"""Frames of a fixed view against single pictures of the same backend."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from hgs_core.base.errors import InputError
from hgs_core.render import FixedView, contributions, rasterize
from hgs_core.render.types import ScreenStatistics
from tests.hgs_core.render.comparison import every_backend
from tests.hgs_core.render.scenes import camera, dynamic_splats, static_splats
from tests.tolerances import assert_close

BACKGROUND = (0.2, 0.5, 0.9)


@every_backend
@pytest.mark.parametrize("antialiased", [False, True])
def test_frames_are_the_pictures_of_their_times(backend: str, antialiased: bool) -> None:
    static = static_splats(150, dtype=torch.float32).map(lambda array: array.requires_grad_())
    fixed = FixedView(static, camera(75, 41), background=BACKGROUND, antialiased=antialiased, backend=backend)
    moments = [(0.0, 120, False), (0.9, 120, True), (0.3, 20, False), (0.3, 0, True), (0.1, 120, True)]
    frames = [fixed.frame(dynamic_splats(count, dtype=torch.float32), time, depth) for time, count, depth in moments]
    for (time, count, depth), frame in zip(moments, frames, strict=True):
        expected = rasterize(
            static,
            dynamic_splats(count, dtype=torch.float32),
            camera(75, 41),
            time,
            background=BACKGROUND,
            backend=backend,
            gradients="none",
            antialiased=antialiased,
            depth=depth,
        )
        assert torch.equal(frame.rgb, expected.rgb)
        assert torch.equal(frame.alpha, expected.alpha)
        assert not frame.rgb.requires_grad
        if depth:
            assert frame.depth is not None
            assert expected.depth is not None
            assert torch.equal(frame.depth, expected.depth)
        else:
            assert frame.depth is None


@every_backend
def test_contributions_are_those_of_single_pictures(backend: str) -> None:
    static, moving = static_splats(150, dtype=torch.float32), dynamic_splats(120, dtype=torch.float32)
    fixed = FixedView(static, camera(75, 41), antialiased=True, backend=backend)
    fixed.frame(moving, 0.9)
    for time in (0.0, 0.3):
        expected = contributions(static, moving, camera(75, 41), time, backend=backend, antialiased=True)
        found = fixed.contributions(moving, time)
        assert np.array_equal(found.total, expected.total)
        assert np.array_equal(found.peak, expected.peak)


@every_backend
def test_differentiable_frames_have_the_gradients_of_single_pictures(backend: str) -> None:
    static = static_splats(150, dtype=torch.float32)
    fixed = FixedView(static, camera(75, 41), antialiased=True, backend=backend)
    tiles = np.random.default_rng(0).uniform(size=(3, 5)) < 0.5
    for time, mask in ((0.2, None), (0.7, tiles)):
        found = []
        for alone in (False, True):
            moving = dynamic_splats(120, dtype=torch.float32).map(lambda array: array.requires_grad_())
            seen = ScreenStatistics.zeros(270)
            if alone:
                picture = rasterize(
                    static,
                    moving,
                    camera(75, 41),
                    time,
                    backend=backend,
                    gradients="dynamic",
                    tile_mask=mask,
                    statistics=seen,
                    antialiased=True,
                ).rgb
            else:
                picture = fixed.differentiable_frame(moving, time, tile_mask=mask, statistics=seen).rgb
            (picture * torch.linspace(-1, 1, 75)).sum().backward()
            found.append((picture.detach(), {name: array.grad for name, array in moving.items()}, seen))
        assert_close(found[0][0].numpy(), found[1][0].numpy(), "picture")
        for name, gradient in found[0][1].items():
            assert gradient is not None
            assert gradient.any()
            assert_close(gradient.numpy(), found[1][1][name].numpy(), "gradients")
        np.testing.assert_array_equal(found[0][2].count, found[1][2].count)
        assert found[0][2].count[150:].any()


@every_backend
def test_either_set_may_be_missing(backend: str) -> None:
    fixed = FixedView(None, camera(), background=BACKGROUND, backend=backend)
    assert not fixed.frame(None).alpha.any()
    assert fixed.frame(dynamic_splats(100, dtype=torch.float32), 0.4).alpha.any()


@every_backend
def test_a_broken_frame_does_not_spoil_the_next(backend: str) -> None:
    static, good = static_splats(50, dtype=torch.float32), dynamic_splats(50, dtype=torch.float32)
    good.time_log_precisions[:] = -5
    broken = good.map(torch.clone)
    broken.rgb[3] = torch.nan
    fixed = FixedView(static, camera(), backend=backend)
    expected = fixed.frame(good, 0.4)
    with pytest.raises(InputError, match=r"rgb\[3\] is nan"):
        fixed.frame(broken, 0.4)
    assert torch.equal(fixed.frame(good, 0.4).rgb, expected.rgb)


def test_an_unknown_backend_is_refused() -> None:
    with pytest.raises(InputError, match="use auto, cpu, triton or reference"):
        FixedView(None, camera(), backend="vulkan")
