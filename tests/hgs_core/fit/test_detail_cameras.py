"""From how far, and from which side, detail is looked at."""

from __future__ import annotations

import numpy as np

from hgs_core.fit.detail_cameras import best_directions, detail_distances
from hgs_core.scene.camera import Camera, looking_at


def test_distances_follow_from_the_sizes_of_splats_around() -> None:
    """Deviations of 0.01 and 0.04 have two pixels at 5 and 20 focal lengths of 1,000 pixels; too near is too near."""
    places = np.concatenate([np.zeros((300, 3)), np.full((300, 3), 50.0), np.full((300, 3), -50.0)])
    sizes = np.repeat([0.01, 0.04, 1e-6], 300)
    log_scales = np.log(np.stack([sizes, sizes, sizes / 100], axis=1)).astype(np.float32)
    found = detail_distances(places[[0, 300, 600]], places, log_scales, 1000.0, 100.0)
    np.testing.assert_allclose(found, [5, 20, 2], rtol=1e-5)


def test_the_side_that_shows_most_is_taken_until_others_show_nearly_as_much() -> None:
    directions = np.array([[0, 0, -1.0], [1.0, 0, 0], [0, 0, 1.0]])

    def camera(target: np.ndarray, aside: np.ndarray) -> Camera:
        return Camera("", 8, 8, 8, 8, 4, 4, looking_at(target + aside, target))

    def seen(one: Camera) -> int:
        return {-1: 100, 0: 90, 1: 5}[round(float(one.position[2]))]

    found = best_directions(np.zeros((4, 3)), np.ones(4), directions, camera, seen)
    assert found[:, 2].tolist() == [-1, 0, -1, 0]
