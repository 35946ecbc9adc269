"""The front of all backends."""

from __future__ import annotations

import pytest
import torch

from hgs_core.native import library
from hgs_core.render import rasterize
from tests.hgs_core.render.scenes import camera, dynamic_splats, static_splats


def test_float64_is_drawn_by_the_reference() -> None:
    render = rasterize(static_splats(10), None, camera())
    assert render.rgb.dtype == torch.float64


@pytest.mark.skipif(not library.available(), reason="the compiled library is not there")
def test_auto_and_reference_agree() -> None:
    static, dynamic = static_splats(40, dtype=torch.float32), dynamic_splats(30, dtype=torch.float32)
    auto, truth = (rasterize(static, dynamic, camera(), 0.3, backend=b) for b in ("auto", "reference"))
    torch.testing.assert_close(auto.rgb, truth.rgb, rtol=0, atol=1e-5)
    torch.testing.assert_close(auto.alpha, truth.alpha, rtol=0, atol=1e-5)
