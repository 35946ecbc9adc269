"""Labels of points, on views of 53x40 pixels in which the point (x, y, 1) is at column 50 x + 26.5, row 50 y + 20."""

from __future__ import annotations

import numpy as np

from hgs_core.points.point_labels import label_points
from hgs_core.scene.camera import Camera

VIEWS = [Camera(name, 53, 40, 50, 50, 26.5, 20, np.eye(4)) for name in "abc"]


def bar(left: int) -> np.ndarray:
    mask = np.zeros((40, 53), bool)
    mask[:, left : left + 8] = True
    return mask


def test_a_point_moves_where_the_masks_say_so() -> None:
    on_bar, beside, behind, outside = (-0.25, 0, 1), (0.25, 0, 1), (-0.25, 0, -1), (3, 0, 1)
    xyz = np.array([on_bar, beside, behind, outside])
    np.testing.assert_allclose(label_points(VIEWS, [bar(10)] * 3, xyz), [1, 0, 0, 0])


def test_the_label_is_the_share_of_the_views() -> None:
    np.testing.assert_allclose(label_points(VIEWS, [bar(10), bar(10), bar(40)], np.array([(-0.25, 0, 1)])), [2 / 3])


def test_only_the_views_that_see_a_point_vote() -> None:
    xyz = np.array([(-0.25, 0, 1)] * 3)
    seen = np.array([[True, False, False], [True, False, True], [False, False, False]])
    np.testing.assert_allclose(label_points(VIEWS, [bar(10), bar(10), bar(40)], xyz, seen), [1, 0.5, 0])


def test_no_points_have_no_labels() -> None:
    assert label_points(VIEWS, [bar(10)] * 3, np.zeros((0, 3))).shape == (0,)
