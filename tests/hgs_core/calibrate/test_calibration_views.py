from __future__ import annotations

import numpy as np

from hgs_core.calibrate.calibration_views import Pinhole, look


def noise(seed: int, width: int, height: int) -> np.ndarray:
    coarse = np.random.default_rng(seed).integers(0, 255, (height // 8, width // 8, 3)).astype(np.uint8)
    return np.kron(coarse, np.ones((8, 8, 1), np.uint8))


def test_later_moments_have_features_of_what_moves_alone() -> None:
    still = noise(1, 320, 240)

    def read(camera: int, frame: int) -> np.ndarray:
        picture = still.copy()
        picture[80:160, 80:160] = noise(2 + frame, 80, 80)
        return picture

    view = look(["a", "b"], [None, None], read, 30, lambda progress: None)[1]
    assert len(view.features) in (4, 10)
    assert len(view.features[0].xy) > 100
    for later in view.features[1:]:
        assert len(later.xy) > 0
        assert (later.xy > 70).all()
        assert (later.xy < 170).all()


def test_features_of_large_pictures_are_in_their_pixels() -> None:
    picture = noise(3, 320, 240).repeat(8, axis=0).repeat(8, axis=1)
    known = Pinhole(2000, 2000, 1280, 960)
    (view,) = look(["a"], [known], lambda camera, frame: picture, 1, lambda progress: None)
    assert (view.width, view.height, view.known) == (2560, 1920, known)
    assert view.features[0].xy.max() > 2000
