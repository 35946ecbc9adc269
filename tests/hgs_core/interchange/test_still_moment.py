from __future__ import annotations

import numpy as np
import pytest

from hgs_core.interchange.still_moment import scene_at
from hgs_core.scene import HybridScene, Segment, evaluate
from tests.hgs_core.interchange.scenes import dynamics, statics


@pytest.mark.parametrize("seconds", [2.0, 3.1, 4.0])
def test_a_moment_is_what_the_equations_of_time_say(scene: HybridScene[np.ndarray], seconds: float) -> None:
    found = scene_at(scene, seconds)
    positions, quats, opacities = evaluate(scene.segments[0].dynamic, (seconds - 2) / 2)
    alive = opacities >= 1 / 255
    assert len(found) == 50 + alive.sum() < 80
    np.testing.assert_array_equal(found.means[:50], scene.static.means)
    np.testing.assert_allclose(found.means[50:], positions[alive], atol=1e-6)
    np.testing.assert_allclose(found.quats[50:], quats[alive], atol=1e-6)
    np.testing.assert_allclose(1 / (1 + np.exp(-found.opacity_logits[50:])), opacities[alive], rtol=1e-4)
    np.testing.assert_array_equal(found.rgb[50:], scene.segments[0].dynamic.rgb[alive])


def test_the_segment_of_the_moment_is_shown(scene: HybridScene[np.ndarray]) -> None:
    second = Segment(4.0, 6.0, dynamics(5, seed=9))
    second.dynamic.time_log_precisions[:] = -20.0  # seen throughout
    found = scene_at(HybridScene(statics(), (scene.segments[0], second)), 5.0)
    np.testing.assert_allclose(found.rgb[50:], second.dynamic.rgb)
