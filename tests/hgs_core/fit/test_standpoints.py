"""Places to stand in: in a room, and not in the open nor in the midst of things."""

from __future__ import annotations

import numpy as np

from hgs_core.fit.standpoints import standpoints
from hgs_core.scene import DynamicSplats, HybridScene, Segment
from tests.hgs_core.fit.test_orbit_cameras import ROOM, box, cloud, walls


def found(places: np.ndarray, deviation: float) -> np.ndarray:
    splats = cloud(places)
    splats.log_scales[:], splats.opacity_logits[:] = np.log(deviation), 6.0
    scene = HybridScene(splats, (Segment(0.0, 0.0, DynamicSplats.empty()),))
    count = len(places)
    return standpoints(scene, splats.means.astype(np.float64), np.full(count, 2 * deviation), np.ones(count))


def test_a_room_has_some_inside() -> None:
    inside = found(walls(3000) * ROOM, 0.15)
    assert len(inside) > 5
    assert (np.abs(inside) < ROOM).all()


def test_a_single_wall_and_a_solid_block_have_none() -> None:
    assert len(found(box(2000) * [3, 1.5, 0.01], 0.1)) == 0
    assert len(found(box(4000), 0.1)) == 0
