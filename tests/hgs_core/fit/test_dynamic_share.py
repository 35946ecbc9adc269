"""The share with the fewest bytes, against all pairs of coarsenesses."""

from __future__ import annotations

from typing import cast

import numpy as np
import pytest

from hgs_core.fit.dynamic_share import dynamic_share
from hgs_core.fit.encoding_loss import Decibels, Loss
from hgs_core.scene import HybridScene, Segment
from hgs_core.scene.splats import joined
from tests.synthetic import synthetic_scene


class KnownLoss:
    """A stand-in for drawing the views: the loss of the dynamic splats alone."""

    def __init__(self, whole: float, moving: float) -> None:
        self.lost = Decibels(whole, moving)
        self.asked = 0

    def of(self, scene: HybridScene[np.ndarray]) -> Decibels:
        self.asked += 1
        return self.lost


def share(lost: Decibels, alone: KnownLoss, copies: int = 1, *, tuned: bool = False) -> float:
    """The share for a scene of 150 static splats and 3 dynamic ones for each copy."""
    static, dynamic = (splats.map(lambda tensor: tensor.numpy()) for splats in synthetic_scene())
    scene = HybridScene(static, (Segment(0.0, 1.0, joined([dynamic] * copies)),))
    return dynamic_share(scene, scene, cast(Loss, alone), lost, tuned=tuned)


@pytest.mark.parametrize(("copies", "dynamic_part"), [(20, 0.4), (100, 0.4), (40, 0.38), (100, 0.25)])
def test_it_is_that_of_the_coarsest_pair_that_keeps_both_limits(copies: int, dynamic_part: float) -> None:
    """Every static coarseness is tried (squared), each with the coarsest dynamic one; which is not above it."""
    found = share(Decibels(0.1, 0.4), KnownLoss(0.05, dynamic_part), copies)
    static = np.linspace(0.01, 20, 20_000)[:-1]
    dynamic = np.minimum((1 - 0.05 * static) / 0.05, (1 - (0.4 - dynamic_part) * static) / dynamic_part)
    dynamic = np.minimum(np.maximum(dynamic, 1e-9), static)
    best = np.argmax(150 * np.log(static) + 2.5 * 3 * copies * np.log(dynamic))
    assert found == pytest.approx((dynamic[best] / static[best]) ** 0.5, rel=0.03)


def test_it_is_smaller_where_training_further_will_make_good_what_whole_pictures_lose() -> None:
    plain, tuned = (share(Decibels(0.1, 0.4), KnownLoss(0.05, 0.4), 100, tuned=tuned) for tuned in (False, True))
    assert tuned < 0.95 * plain


def test_finer_dynamic_splats_do_not_make_good_what_static_ones_lose() -> None:
    assert share(Decibels(0.1, 0.4), KnownLoss(0.01, 0.0)) == 1


@pytest.mark.parametrize("lost", [Decibels(0.1, 0.1), Decibels(0.1, None), Decibels(-0.1, -0.2), Decibels(0.0, 0.0)])
def test_one_coarseness_will_do_where_moving_pixels_lose_no_more(lost: Decibels) -> None:
    alone = KnownLoss(0.05, 0.4)
    assert share(lost, alone) == 1
    assert alone.asked == 0
