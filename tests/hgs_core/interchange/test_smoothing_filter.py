"""Mip-Splatting's filter, fused by hand."""

from __future__ import annotations

import numpy as np

from hgs_core.interchange.changes import nonzero
from hgs_core.interchange.ply.ply_table import write_ply
from hgs_core.interchange.smoothing_filter import fused
from hgs_core.scene.opacities import opacities_of
from tests.hgs_core.interchange.scenes import Write, statics
from tests.hgs_core.interchange.test_splat_properties import COUNT, columns, told


def test_a_smoothing_filter_is_fused_as_its_trainer_does(written: Write) -> None:
    """Mip-Splatting: variances grow by the filter's square, opacity by the root of the ratio of determinants."""
    widths = np.random.default_rng(0).uniform(0.001, 0.1, COUNT)
    widths[:5] = 0.0
    found, changes = told(written("x.ply", write_ply(columns() | {"filter_3D": widths})))
    assert changes == ["scale and opacity"]
    given = statics(COUNT)
    before = np.exp(2.0 * given.log_scales)
    after = before + widths[:, None].astype(np.float32) ** 2
    np.testing.assert_allclose(np.exp(2.0 * found.log_scales), after, rtol=1e-4)
    share = np.sqrt(before.prod(axis=1) / after.prod(axis=1))
    np.testing.assert_allclose(
        opacities_of(found.opacity_logits), np.maximum(opacities_of(given.opacity_logits) * share, 1e-6), rtol=1e-3
    )
    assert nonzero([fused(given.log_scales, given.opacity_logits, np.zeros(COUNT))[2]]) == ()
