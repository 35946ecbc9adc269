from __future__ import annotations

from hgs_core.points.points_config import PointsConfig


def test_what_moves_has_points_for_every_second_and_for_one_at_least() -> None:
    config = PointsConfig(dynamic=8)
    assert (config.dynamic_in(2.5), config.dynamic_in(0.0)) == (20, 8)
