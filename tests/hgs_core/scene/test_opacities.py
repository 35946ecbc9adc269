from __future__ import annotations

import math

import numpy as np
import pytest

from hgs_core.scene.opacities import logits_of, logits_of_any, opacities_of


@pytest.mark.parametrize(
    ("logit", "opacity"), [(-math.inf, 0.0), (-800.0, math.exp(-800)), (0.0, 0.5), (2.0, 1 / (1 + math.exp(-2)))]
)
def test_opacities_are_the_sigmoid_of_logits_of_any_size(logit: float, opacity: float) -> None:
    assert opacities_of(np.array([logit, -logit]))[0] == pytest.approx(opacity, rel=1e-15)
    assert opacities_of(np.array([logit, -logit]))[1] == pytest.approx(1 - opacity, rel=1e-15)


def test_logits_come_back() -> None:
    logits = np.linspace(-9, 9, 37).astype(np.float32)
    np.testing.assert_allclose(logits_of(opacities_of(logits)), logits, rtol=1e-6, atol=1e-6)


def test_opacities_of_nothing_and_all_have_the_logits_of_their_neighbours() -> None:
    logits = logits_of_any(np.array([0.0, 1e-6, 0.25, 1.0]))
    np.testing.assert_allclose(logits, [-13.815510, -13.815510, math.log(1 / 3), 13.815510], rtol=1e-6)
