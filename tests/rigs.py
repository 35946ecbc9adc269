"""Rigs of cameras around a cloud of points, and the matches that they would find."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from hgs_core.check.epipolar import Pair, Rig
from hgs_core.scene.camera import Camera, looking_at

__all__ = ["dome", "matches_of", "rig_and_matches"]


def dome(count: int = 8) -> list[Camera]:
    """Cameras all around at three heights, three units away, each turned a little about its own axis."""
    cameras = []
    for i in range(count):
        angle = 2 * np.pi * i / count
        place = 3 * np.array([np.sin(angle), -0.2 - 0.2 * (i % 3), np.cos(angle)]) + (5.0, 0.0, 2.0)
        pose = looking_at(place, np.array([5.0, 0.0, 2.0]), roll=0.1 * (i % 4))
        cameras.append(Camera(f"cam{i:02d}", 640, 480, 600.0, 600.0, 320.0, 240.0, pose))
    return cameras


def matches_of(cameras: Sequence[Camera], noise: float = 0.2, chance: float = 0.1) -> dict[tuple[int, int], Pair]:
    """The views of 60 points in every two cameras: pixels with noise, and a share of chance matches."""
    numbers = np.random.default_rng(3)
    points = np.array([5.0, 0.0, 2.0]) + numbers.uniform(-1, 1, (60, 3))
    pairs = {}
    for a, b in combinations(range(len(cameras)), 2):
        first, second = (cameras[i].project(points)[0] + numbers.normal(0, noise, (60, 2)) for i in (a, b))
        wrong = numbers.random(60) < chance
        second[wrong] = numbers.uniform(0, 480, (int(wrong.sum()), 2))
        pairs[a, b] = Pair(first, second, 60.0)
    return pairs


def rig_and_matches(count: int = 8) -> tuple[Rig, dict[tuple[int, int], Pair]]:
    """The true rig and its matches."""
    cameras = dome(count)
    return Rig.of(cameras), matches_of(cameras)
