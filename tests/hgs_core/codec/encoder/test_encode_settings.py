"""Settings out of range are refused by name."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.codec import EncodeSettings


@pytest.mark.parametrize(
    "fields",
    [
        {"position_step": 0.0},
        {"rgb_step": np.nan},
        {"prune": -1.0},
        {"prune_dynamic": -1.0},
        {"static_chunk_splats": 0},
        {"compression_level": 23},
    ],
)
def test_settings_out_of_range_are_named(fields: dict[str, Any]) -> None:
    with pytest.raises(InputError, match=rf"encode\.{next(iter(fields))}: "):
        EncodeSettings(**fields)
