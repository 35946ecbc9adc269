from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hgs_core.scene import DynamicSplats, HybridScene, Segment
from tests.hgs_core.interchange.scenes import Write, dynamics, statics


@pytest.fixture
def scene() -> HybridScene[np.ndarray]:
    """50 static and 30 dynamic splats, 2 to 4 s."""
    return HybridScene(statics(), (Segment(2.0, 4.0, dynamics()),))


@pytest.fixture
def still() -> HybridScene[np.ndarray]:
    """50 static splats."""
    return HybridScene(statics(), (Segment(0.0, 0.0, DynamicSplats.empty()),))


@pytest.fixture
def written(tmp_path: Path) -> Write:
    """Write bytes to a file of this name."""

    def write(name: str, data: bytes) -> Path:
        path = tmp_path / name
        path.write_bytes(data)
        return path

    return write
