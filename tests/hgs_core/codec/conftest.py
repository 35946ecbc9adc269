from __future__ import annotations

import numpy as np
import pytest
from hypothesis import settings

from hgs_core.scene.camera import Camera, looking_at

settings.register_profile("untimed", deadline=None)
settings.load_profile("untimed")


@pytest.fixture
def cameras() -> list[Camera]:
    """Eight cameras on a ring of 4 m around the origin, 1.4 m above it (y points down)."""
    found = []
    for i in range(8):
        angle = 2 * np.pi * i / 8
        position = np.array([4 * np.cos(angle), -1.4, 4 * np.sin(angle)])
        pose = looking_at(position, np.zeros(3))
        found.append(Camera(f"cam{i:02}", 640, 360, 500.0, 500.0, 320.0, 180.0, pose))
    return found
