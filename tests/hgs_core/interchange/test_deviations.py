from __future__ import annotations

import numpy as np

from hgs_core.interchange.deviations import deviations_limited, deviations_of, log_scales_of


def test_deviations_are_exponentials_and_come_back() -> None:
    log_scales = np.linspace(-12, 5, 30, dtype=np.float32).reshape(10, 3)
    stored = deviations_of(log_scales)
    np.testing.assert_allclose(stored, [[np.e ** float(x) for x in row] for row in log_scales], rtol=1e-6)
    assert stored.dtype == np.float32
    np.testing.assert_allclose(log_scales_of(stored), log_scales, atol=2e-6)


def test_those_that_no_normal_float_holds_are_limited_and_counted() -> None:
    log_scales = np.float32([[-100, 0, 0], [0, 0, 100], [-80, 80, 1]])
    assert np.log(deviations_of(log_scales)).round(4).tolist() == [[-80, 0, 0], [0, 0, 80], [-80, 80, 1]]
    assert deviations_limited(log_scales).count == 2


def test_no_thickness_and_a_negative_one_have_logarithms_that_tell() -> None:
    found = log_scales_of(np.array([[0.0, -1.0, 1.0]]))
    np.testing.assert_array_equal(found, [[-np.inf, np.nan, 0]])
