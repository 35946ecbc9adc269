from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.points.point_cloud import PointCloud


def cloud(count: int) -> PointCloud:
    numbers = np.random.default_rng(count)
    shapes = [(count, 3), (count, 3), (count,), (count,), (count,), (count, 3), (count, 3)]
    return PointCloud(*(numbers.random(shape, np.float32) for shape in shapes))


def test_saved_points_come_back(tmp_path: Path) -> None:
    points = cloud(7)
    np.savez(tmp_path / "points.npz", **dataclasses.asdict(points))
    loaded = PointCloud.load(tmp_path / "points.npz")
    for name in ("xyz", "rgb", "times", "dynamic", "spacing", "velocity", "normal"):
        np.testing.assert_array_equal(getattr(loaded, name), getattr(points, name))


def test_concatenation_keeps_the_order() -> None:
    whole = PointCloud.concatenate([cloud(2), cloud(3)])
    assert len(whole) == 5
    np.testing.assert_array_equal(whole.take(slice(2, None)).xyz, cloud(3).xyz)
    assert len(PointCloud.concatenate([])) == 0


@pytest.mark.parametrize("damage", ["missing", "truncated", "field", "nan"])
def test_unreadable_points_are_named(tmp_path: Path, damage: str) -> None:
    path = tmp_path / "points.npz"
    points = cloud(5)
    if damage == "nan":
        points.xyz[0, 0] = np.nan
    np.savez(path, **dataclasses.asdict(points))
    if damage == "missing":
        path.unlink()
    elif damage == "truncated":
        path.write_bytes(path.read_bytes()[:100])
    elif damage == "field":
        np.savez(path, xyz=points.xyz)
    with pytest.raises(InputError, match=r"points\.npz"):
        PointCloud.load(path)
