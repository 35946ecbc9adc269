"""Rigs of known cameras, with projections of known points as features."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from hgs_core.calibrate.calibration_views import Pinhole, View
from hgs_core.calibrate.structure import Solution, solve
from hgs_core.points.features import Features
from hgs_core.scene.camera import Camera, looking_at

MOMENTS = 3


def rig(count: int = 5) -> list[Camera]:
    cameras = []
    for i in range(count):
        angle = np.radians(25 * i)
        place = 4 * np.array([np.sin(angle), -0.15 * (i % 3), np.cos(angle)])
        cameras.append(Camera(f"cam{i}", 640, 480, 550, 550, 320, 240, looking_at(place, np.zeros(3))))
    return cameras


def seen_by(cameras: list[Camera], known: bool, noise: float = 0.1) -> list[View]:
    numbers = np.random.default_rng(5)
    features: list[list[Features]] = [[] for _ in cameras]
    for _ in range(MOMENTS):
        points = numbers.uniform(-1, 1, (150, 3))
        stored = numbers.integers(0, 100, (150, 128)).astype(np.float64)
        stored *= 512 / np.linalg.norm(stored, axis=1, keepdims=True)
        for camera, found in zip(cameras, features, strict=True):
            pixels = camera.project(points)[0] + numbers.normal(0, noise, (150, 2))
            found.append(Features(pixels, stored.round().clip(0, 255).astype(np.float32)))
    lens = Pinhole(550, 550, 320, 240) if known else None
    return [View(c.name, 640, 480, lens, tuple(found)) for c, found in zip(cameras, features, strict=True)]


def worst_turn(solution: Solution, cameras: list[Camera]) -> float:
    """Return the largest angle between the relative rotations found and the true ones, degrees."""
    true = {camera.name: camera.world_to_camera[:3, :3] for camera in cameras}
    found = {camera.name: camera.world_to_camera[:3, :3] for camera in solution.cameras}
    first = cameras[0].name
    angles = []
    for name in found:
        off = found[name] @ found[first].T @ (true[name] @ true[first].T).T
        angles.append(np.degrees(np.arccos(np.clip((np.trace(off) - 1) / 2, -1, 1))))
    return float(max(angles))


@pytest.mark.parametrize("known", [True, False])
def test_cameras_are_found_from_features_of_several_moments(known: bool) -> None:
    cameras = rig()
    solution = solve(seen_by(cameras, known), lambda progress: None)
    assert solution is not None
    assert len(solution.cameras) == 5
    assert worst_turn(solution, cameras) < (0.05 if known else 0.3)
    assert solution.cameras[0].parameters[0] == pytest.approx(550, rel=1e-9 if known else 0.02)
    assert solution.error < 0.3


def test_equal_input_gives_equal_cameras() -> None:
    first, second = (solve(seen_by(rig(), False), lambda progress: None) for _ in range(2))
    assert first is not None
    assert second is not None
    for one, other in zip(first.cameras, second.cameras, strict=True):
        np.testing.assert_array_equal(one.world_to_camera, other.world_to_camera)


def test_cameras_with_lenses_of_their_own_are_found() -> None:
    cameras = [dataclasses.replace(c, fx=550 + 60 * i, fy=550 + 60 * i) for i, c in enumerate(rig(6))]
    solution = solve(seen_by(cameras, False), lambda progress: None)
    assert solution is not None
    found = [camera.parameters[0] for camera in solution.cameras]
    assert found == pytest.approx([camera.fx for camera in cameras], rel=0.05)


def test_cameras_that_see_nothing_alike_have_no_solution() -> None:
    views = seen_by(rig(4), True)
    numbers = np.random.default_rng(9)
    apart = [
        dataclasses.replace(
            view,
            features=tuple(
                Features(one.xy, numbers.permuted(one.descriptors, axis=1).astype(np.float32)) for one in view.features
            ),
        )
        for view in views
    ]
    assert solve(apart, lambda progress: None) is None
