from __future__ import annotations

import pytest

from hgs_core.base.errors import InputError
from hgs_core.train.density_config import DensityConfig


def test_a_rule_that_is_out_of_range_is_refused_by_name() -> None:
    with pytest.raises(InputError, match=r"config\.train\.density\.max_static: 0 is out of range"):
        DensityConfig(max_static=0)
