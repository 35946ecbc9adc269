"""The position polynomial against numpy's."""

from __future__ import annotations

import numpy as np
import pytest

from hgs_core.scene.motion import position, recentred


@pytest.mark.parametrize("count", [2, 4, 6])
def test_a_recentred_path_is_the_same_path(count: int) -> None:
    generator = np.random.default_rng(count)
    motion, by, at = generator.normal(size=(5, count, 3)), generator.normal(size=(5, 1)), generator.normal(size=(5, 1))
    expected = np.stack(
        [
            [np.polynomial.polynomial.polyval(t[0], path[:, axis]) for axis in range(3)]
            for path, t in zip(motion, at, strict=True)
        ]
    )
    np.testing.assert_allclose(
        position(np.stack(recentred(motion, by), axis=1), at - by), expected, rtol=1e-9, atol=1e-9
    )
