"""Scenes that cannot be encoded are refused by splat and field."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.scene.camera import Camera
from tests.hgs_core.codec.scenes import encode, scene


@pytest.mark.parametrize(("field", "value"), [("means", np.nan), ("log_scales", np.inf), ("opacity_logits", np.nan)])
def test_a_number_that_is_not_finite_is_named_and_nothing_is_written(
    tmp_path: Path, cameras: list[Camera], field: str, value: float
) -> None:
    given = scene()
    getattr(given.static, field)[7] = value
    with pytest.raises(InputError, match=f"static splat 7: {field} is not a finite number"):
        encode(given, tmp_path / "out", cameras)
    assert not (tmp_path / "out").exists()


def test_a_splat_that_lives_far_from_its_segment_is_named(tmp_path: Path, cameras: list[Camera]) -> None:
    given = scene()
    given.segments[0].dynamic.time_centers[5] = 1e6
    given.segments[0].dynamic.time_log_precisions[5] = -1e4
    given.segments[0].dynamic.opacity_logits[5] = 3
    with pytest.raises(InputError, match="dynamic splat 5: time_centers reaches 1e"):
        encode(given, tmp_path, cameras)
