from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

from hgs_core.check.epipolar import Rig
from hgs_core.check.late_cameras import find_late, moved_error
from hgs_core.check.silhouette_pairs import SilhouettePair, Silhouettes
from hgs_core.check.silhouettes import silhouettes_of
from hgs_core.check.trials import Trial
from tests.walking_body import CAMERAS, MOMENTS, body, mask_of, shapes_of

RIG = Rig.of(CAMERAS)


def pairs_with(late: int) -> dict[tuple[int, int], SilhouettePair]:
    """The silhouettes of all cameras, of which the second is so many moments late."""
    masks = [mask_of(CAMERAS[1], body(np.clip(m - late, 0, MOMENTS - 1) / (MOMENTS - 1))) for m in range(MOMENTS)]
    second = Silhouettes.of([silhouettes_of(mask, CAMERAS[1]) for mask in masks])
    shapes = [shapes_of(0), second, shapes_of(2)]
    return {(a, b): SilhouettePair(shapes[a], shapes[b]) for a, b in combinations(range(3), 2)}


@pytest.mark.parametrize(("late", "way"), [(4, "about 40 behind"), (-3, "about 30 ahead of")])
def test_a_camera_with_other_times_is_found(late: int, way: str) -> None:
    found = find_late([Trial(RIG, "", "")], pairs_with(late), [0, 1, 2], 50.0, 5.0)
    assert found is not None
    assert (found.camera, found.steps) == (1, late)
    finding = found.finding([camera.name for camera in CAMERAS], "nothing fits", 10.0)
    assert finding.cameras == ("cam1",)
    assert way in finding.problem
    assert "hgs sync" in finding.cure


def test_poses_that_fit_at_no_time_are_not_late() -> None:
    wrong = RIG.with_pose(1, np.diag((-1.0, -1.0, 1.0, 1.0)) @ RIG.poses[1])
    assert find_late([Trial(wrong, "", "")], pairs_with(4), [1], 50.0, 5.0) is None


def test_an_error_with_other_times_is_that_of_the_cameras_own_pairs() -> None:
    pairs = pairs_with(4)
    assert moved_error(pairs, RIG, 1, 0) is None
    assert (moved_error(pairs, RIG, 1, 4) or 9.0) < 1.5
    assert (moved_error(pairs, RIG, 1, -4) or 0.0) > 5.0
