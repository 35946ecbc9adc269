"""Splats that are the same to the bit."""

from __future__ import annotations

import numpy as np

from hgs_core.scene import StaticSplats
from hgs_core.scene.rows import rows_of
from tests.hgs_core.interchange.scenes import statics


def test_rows_are_the_same_where_all_numbers_are() -> None:
    given, other = statics(5), statics(5)
    other.rgb[3, 2] = np.nextafter(other.rgb[3, 2], np.float32(2))
    assert (rows_of(given) == rows_of(other)).tolist() == [True, True, True, False, True]
    assert len(rows_of(StaticSplats.empty())) == 0
