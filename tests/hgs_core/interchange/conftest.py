from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from hgs_core.scene import DynamicSplats, HybridScene, Segment, StaticSplats


def statics(count: int = 50, seed: int = 0) -> StaticSplats[np.ndarray]:
    rng = np.random.default_rng(seed)
    quats = rng.normal(size=(count, 4))
    return StaticSplats(
        rng.normal(0, 2, (count, 3)).astype(np.float32),
        rng.uniform(-6, -1, (count, 3)).astype(np.float32),
        (quats / np.linalg.norm(quats, axis=1, keepdims=True)).astype(np.float32),
        rng.normal(1, 2, count).astype(np.float32),
        rng.uniform(0.05, 0.95, (count, 3)).astype(np.float32),
    )


def dynamics(count: int = 30, seed: int = 1) -> DynamicSplats[np.ndarray]:
    rng = np.random.default_rng(seed)
    still = statics(count, seed)
    motion = rng.normal(0, 0.5, (count, 4, 3)).astype(np.float32)
    return DynamicSplats(
        motion, np.stack([still.quats, rng.normal(size=(count, 4)).astype(np.float32)], axis=1), still.log_scales,
        np.abs(still.opacity_logits), rng.uniform(0, 1, count).astype(np.float32),
        rng.normal(2, 1, count).astype(np.float32), still.rgb,
    )  # fmt: skip


@pytest.fixture
def scene() -> HybridScene[np.ndarray]:
    """50 static and 30 dynamic splats, 2 to 4 s."""
    return HybridScene(statics(), (Segment(2.0, 4.0, dynamics()),))


@pytest.fixture
def still() -> HybridScene[np.ndarray]:
    """50 static splats."""
    return HybridScene(statics(), (Segment(0.0, 0.0, DynamicSplats.empty()),))


@pytest.fixture
def written(tmp_path: Path) -> Callable[[str, bytes], Path]:
    """Write bytes to a file of this name."""

    def write(name: str, data: bytes) -> Path:
        path = tmp_path / name
        path.write_bytes(data)
        return path

    return write
