"""Contributions by the Triton kernels against the float64 reference."""

from __future__ import annotations

import numpy as np
import torch

from hgs_core.render.reference import contributions_reference
from hgs_core.render.triton.contribution import contributions_triton
from hgs_core.render.types import View
from tests.hgs_core.render.scenes import camera, dynamic_splats, static_splats
from tests.tolerances import assert_close


def test_sums_and_peaks() -> None:
    static, dynamic = static_splats(30), dynamic_splats(30)
    mask = np.array([[True, False], [True, True]])
    view = View(camera(30, 28), 0.4, tile_mask=mask, antialiased=True, gradients="none")
    truth = contributions_reference(static, dynamic, view)
    found = contributions_triton(static.map(torch.Tensor.float), dynamic.map(torch.Tensor.float), view)
    assert truth.peak.any()
    assert_close(found.total, truth.total, "total")
    assert_close(found.peak, truth.peak, "peak")
