"""Offsets by points in known motion, seen by known cameras, one of which is ahead."""

from __future__ import annotations

import numpy as np
import pytest

from hgs_core.check.epipolar import Rig
from hgs_core.check.evidence import CameraEvidence
from hgs_core.check.starts_by_features import feature_offsets, match_leads
from hgs_core.points.features import Features
from tests.rigs import dome

COUNT = 40


def views(ahead: list[float], chance: float = 0.0) -> tuple[Rig, list[CameraEvidence]]:
    cameras = dome(len(ahead))
    numbers = np.random.default_rng(7)
    points = np.array([5.0, 0.0, 2.0]) + numbers.uniform(-0.7, 0.7, (COUNT, 3))
    steps = numbers.normal(0, 0.02, (COUNT, 3))  # about four pixels a frame
    descriptors = numbers.integers(0, 100, (COUNT, 128)).astype(np.float64)
    descriptors *= 512 / np.linalg.norm(descriptors, axis=1, keepdims=True)
    stored = descriptors.round().clip(0, 255).astype(np.float32)
    found = []
    for camera, lead in zip(cameras, ahead, strict=True):
        now, soon = (camera.project(points + steps * (lead + later))[0] for later in (0, 1))
        jump = np.where(numbers.random(COUNT) < chance, 1.0, 0.0)[:, None] * numbers.uniform(-30, 30, (COUNT, 2))
        empty = Features(np.zeros((0, 2)), np.zeros((0, 128), np.float32))
        here, there = Features(now + jump, stored), Features(soon + jump, stored)
        found.append(CameraEvidence((empty, here), (empty, here), {1: there}, None, (0, 0.0)))
    return Rig.of(cameras), found


def offsets(ahead: list[float], chance: float = 0.0) -> list[float | None]:
    rig, seen = views(ahead, chance)
    pairs = [(a, b) for b in range(len(ahead)) for a in range(b)]
    return feature_offsets(len(ahead), match_leads(rig, pairs, seen))


def test_cameras_on_one_clock_are_not_ahead() -> None:
    assert offsets([0.0] * 5) == pytest.approx([0.0] * 5, abs=0.05)


def test_a_camera_that_is_ahead_is_told_with_its_part_of_a_frame() -> None:
    assert offsets([0.0, 2.5, 0.0, 0.0, -1.0], chance=0.3) == pytest.approx([0.0, 2.5, 0.0, 0.0, -1.0], abs=0.3)


def test_chance_tells_nothing() -> None:
    assert offsets([0.0] * 4, chance=1.0).count(None) >= 3
