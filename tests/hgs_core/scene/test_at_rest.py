"""Reference: `evaluate`, which has its own against the equations."""

from __future__ import annotations

import numpy as np
import pytest

from hgs_core.scene import StaticSplats, evaluate
from hgs_core.scene.at_rest import at_rest


@pytest.mark.parametrize("time", [0.0, 0.3, 1.0])
def test_splats_at_rest_are_the_statics_at_every_time(time: float) -> None:
    rng = np.random.default_rng(0)
    shapes = ((9, 3), (9, 3), (9, 4), (9,), (9, 3))
    static = StaticSplats(*(rng.normal(size=shape).astype(np.float32) for shape in shapes))
    found = at_rest(static)
    positions, quats, opacities = evaluate(found, time)
    np.testing.assert_array_equal(positions, static.means)
    np.testing.assert_allclose(quats, static.quats / np.linalg.norm(static.quats, axis=1, keepdims=True), atol=1e-6)
    np.testing.assert_allclose(opacities, 1 / (1 + np.exp(-static.opacity_logits.astype(np.float64))), rtol=1e-6)
    np.testing.assert_array_equal(found.log_scales, static.log_scales)
    np.testing.assert_array_equal(found.rgb, static.rgb)
    assert {array.dtype for _, array in found.items()} == {np.dtype(np.float32)}
