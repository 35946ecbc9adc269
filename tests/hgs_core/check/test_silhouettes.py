from __future__ import annotations

import numpy as np
import pytest

from hgs_core.check.silhouettes import Silhouette, silhouette_frames, silhouettes_of
from tests.walking_body import CAMERAS


def test_corners_are_those_of_the_convex_hull() -> None:
    mask = np.zeros((240, 320), bool)
    mask[100:200, 50:80] = True
    mask[150:160, 80:120] = True
    shape = Silhouette.of(mask, CAMERAS[0])
    assert shape is not None
    assert {tuple(corner) for corner in shape.corners} == {
        (50, 100),
        (80, 100),
        (120, 150),
        (120, 160),
        (80, 200),
        (50, 200),
    }
    assert shape.inside.all()


def test_a_mask_of_another_size_is_measured_in_pixels_of_the_camera() -> None:
    mask = np.zeros((120, 160), bool)
    mask[10:20, 40:60] = True
    shape = Silhouette.of(mask, CAMERAS[0])
    assert shape is not None
    assert (shape.corners.min(axis=0).tolist(), shape.middle.tolist()) == ([80, 20], [100, 30])


def test_corners_at_the_border_of_a_picture_are_known() -> None:
    mask = np.zeros((240, 320), bool)
    mask[200:, 50:80] = True
    shape = Silhouette.of(mask, CAMERAS[0])
    assert shape is not None
    assert dict(zip(map(tuple, shape.corners.tolist()), shape.inside.tolist(), strict=True)) == {
        (50, 200): True,
        (80, 200): True,
        (50, 240): False,
        (80, 240): False,
    }


@pytest.mark.parametrize("marked", [0, 30])
def test_next_to_nothing_has_no_silhouette(marked: int) -> None:
    mask = np.zeros((240, 320), bool)
    mask.flat[:marked] = True
    assert Silhouette.of(mask, CAMERAS[0]) is None


def test_specks_have_no_silhouette_and_each_body_has_its_own() -> None:
    mask = np.zeros((240, 320), bool)
    mask[100:200, 50:80] = mask[50:200, 200:240] = True
    mask[10:14, 300:304] = True
    whole, *bodies = silhouettes_of(mask, CAMERAS[0])
    assert (whole.corners.min(axis=0).tolist(), whole.corners.max(axis=0).tolist()) == ([50, 50], [240, 200])
    assert [body.corners.min(axis=0).tolist() for body in bodies] == [[200, 50], [50, 100]]
    assert len(silhouettes_of(mask[:, :100], CAMERAS[0])) == 1


def test_moments_are_spread_over_a_capture() -> None:
    assert silhouette_frames(300)[0] == 0
    assert silhouette_frames(300)[-1] == 299
    assert len(silhouette_frames(300)) >= 20
    assert silhouette_frames(3) == (0, 1, 2)
