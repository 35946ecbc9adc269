from __future__ import annotations

import math

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.render.types import ScreenStatistics, View
from tests.hgs_core.render.scenes import camera


@pytest.mark.parametrize("time", [math.nan, math.inf, -math.inf])
def test_a_time_that_is_not_finite_is_refused(time: float) -> None:
    with pytest.raises(InputError, match=r"time: .* is not finite"):
        View(camera(), time)


def test_a_mask_has_one_flag_for_each_tile_whole_or_cut() -> None:
    assert View(camera(33, 16), tile_mask=np.ones((1, 3), np.bool_)).tile_mask is not None
    with pytest.raises(InputError, match=r"tile_mask: shape \(3, 1\); give one flag per tile, \(1, 3\)"):
        View(camera(33, 16), tile_mask=np.ones((3, 1), np.bool_))


def test_an_unknown_gradient_set_is_refused_with_those_that_are_known() -> None:
    with pytest.raises(InputError, match="unknown set 'some'; use all, static, dynamic, none"):
        View(camera(), gradients="some")  # type: ignore[arg-type]


def test_rows_of_statistics_are_views() -> None:
    statistics = ScreenStatistics.zeros(5)
    statistics.rows(slice(1, 3)).count[:] += 2
    statistics.rows(slice(3, None)).pull_sum[:] += 0.5
    assert statistics.count.tolist() == [0, 2, 2, 0, 0]
    assert statistics.pull_sum.tolist() == [0, 0, 0, 0.5, 0.5]
