"""Found points on disk, with all that the search goes on from."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.points.found_points import FoundPoints
from hgs_core.points.point_cloud import PointCloud
from tests.hgs_core.points.test_point_cloud import cloud


def found() -> FoundPoints:
    generator = np.random.default_rng(3)
    generator.random(5)
    return FoundPoints(cloud(7), 2, [(0.1, 1 / 3), (0.25, 7.0)], generator)


def test_the_search_goes_on_from_a_file_as_it_would_have(tmp_path: Path) -> None:
    before = found()
    before.save(tmp_path / "0.npz")
    assert [path.name for path in tmp_path.iterdir()] == ["0.npz"]
    after = FoundPoints.load(tmp_path / "0.npz")
    assert (after.at_end, after.ranges) == (before.at_end, before.ranges)
    assert after.points.xyz.tobytes() == before.points.xyz.tobytes()
    np.testing.assert_array_equal(after.generator.random(9), before.generator.random(9))


def test_the_points_alone_can_be_read(tmp_path: Path) -> None:
    found().save(tmp_path / "0.npz")
    assert PointCloud.load(tmp_path / "0.npz").rgb.tobytes() == found().points.rgb.tobytes()


def test_points_without_their_search_are_refused(tmp_path: Path) -> None:
    np.savez(tmp_path / "0.npz", **dataclasses.asdict(cloud(7)))
    with pytest.raises(InputError, match=r"0\.npz: unreadable as first points.*delete it and near\.json beside it"):
        FoundPoints.load(tmp_path / "0.npz")
