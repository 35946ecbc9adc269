"""Contributions: every backend against the reference, and against the pictures they add up to."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from hgs_core.base.errors import InputError
from hgs_core.render import contributions, rasterize
from tests.hgs_core.render.comparison import every_backend
from tests.hgs_core.render.scenes import camera, dynamic_splats, static_splats
from tests.tolerances import assert_close


@every_backend
@pytest.mark.parametrize("antialiased", [False, True])
def test_float32_agrees_with_float64(backend: str, antialiased: bool) -> None:
    static, dynamic = static_splats(150, dtype=torch.float32), dynamic_splats(120, dtype=torch.float32)
    mask = np.random.default_rng(0).random((3, 5)) < 0.6
    for view, tile_mask in ((camera(75, 41), mask), (camera(75, 41), None), (camera(9, 5), None)):
        options = {"tile_mask": tile_mask, "antialiased": antialiased}
        weighed = contributions(static, dynamic, view, 0.4, backend=backend, **options)
        truth = contributions(
            static.map(torch.Tensor.double), dynamic.map(torch.Tensor.double), view, 0.4, backend="reference", **options
        )
        assert weighed.total.shape == weighed.peak.shape == (270,)
        assert_close(weighed.total, truth.total, "total")
        assert_close(weighed.peak, truth.peak, "peak")


@every_backend
def test_they_add_up_to_the_coverage(backend: str) -> None:
    static, view = static_splats(150, dtype=torch.float32), camera(75, 41)
    weighed = contributions(static, None, view, backend=backend)
    coverage = rasterize(static, None, view, backend=backend).alpha.sum()
    assert float(weighed.total.sum()) == pytest.approx(float(coverage), rel=1e-5)
    assert (weighed.peak <= weighed.total).all()
    assert (weighed.peak < 1).all()
    assert ((weighed.peak > 0) == (weighed.total > 0)).all()


@every_backend
def test_what_is_out_of_sight_contributes_nothing(backend: str) -> None:
    static = static_splats(150, dtype=torch.float32)
    static.means[::2, 2] -= 20
    weighed = contributions(static, dynamic_splats(0, dtype=torch.float32), camera(), backend=backend)
    assert not weighed.total[::2].any()
    assert not weighed.peak[::2].any()
    assert weighed.total.any()


@every_backend
def test_no_splats(backend: str) -> None:
    for static in (None, static_splats(0, dtype=torch.float32)):
        assert contributions(static, None, camera(), backend=backend).total.shape == (0,)


def test_an_unknown_backend_is_refused() -> None:
    with pytest.raises(InputError, match="use auto, cpu, triton or reference"):
        contributions(None, None, camera(), backend="vulkan")
