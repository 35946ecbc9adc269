from __future__ import annotations

import numpy as np

from hgs_core.scene.rotations import unit_quaternions, units_and_norms


def test_quaternions_get_unit_length_and_those_of_no_length_are_the_identity() -> None:
    given = np.array([[0, 3, 0, -4], [0, 0, 0, 0], [1e-13, 0, 0, 0], [2, 0, 0, 0]], np.float32)
    units, norms = units_and_norms(given)
    np.testing.assert_allclose(units, [[0, 0.6, 0, -0.8], [1, 0, 0, 0], [1, 0, 0, 0], [1, 0, 0, 0]])
    np.testing.assert_array_equal(norms, [[5], [1], [1], [2]])
    np.testing.assert_array_equal(unit_quaternions(given), units)
