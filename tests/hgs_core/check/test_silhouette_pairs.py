from __future__ import annotations

import numpy as np
import pytest

from hgs_core.check.epipolar import FAR, Rig
from hgs_core.check.silhouette_pairs import SilhouettePair, Silhouettes
from hgs_core.check.silhouettes import Silhouette, silhouettes_of
from tests.walking_body import CAMERAS, MOMENTS, body, mask_of, shapes_of

SECOND = Silhouettes.of([silhouettes_of(mask_of(CAMERAS[1], body(0.0)), CAMERAS[1])])


def test_tangents_of_a_body_meet_where_the_poses_are_right() -> None:
    rig = Rig.of(CAMERAS)
    for a, b in ((0, 1), (1, 2), (0, 2)):
        pair = SilhouettePair(shapes_of(a), shapes_of(b))
        assert pair.tells
        assert pair.error(rig, a, b) < 1.5
        turned = rig.with_pose(b, np.diag((-1.0, -1.0, 1.0, 1.0)) @ rig.poses[b])
        assert pair.error(turned, a, b) > 10


def test_rays_that_part_are_far_apart() -> None:
    rig = Rig.of(CAMERAS)
    behind = rig.with_pose(1, np.diag((1.0, -1.0, -1.0, 1.0)) @ rig.poses[1])
    assert SilhouettePair(shapes_of(0), shapes_of(1)).error(behind, 0, 1) == FAR
    assert SilhouettePair(shapes_of(0), shapes_of(1)).error(rig.with_pose(1, rig.poses[0]), 0, 1) == FAR


def test_tangents_are_those_of_what_lies_inside_both_pictures() -> None:
    whole, cut = [], []
    for second in np.linspace(0, 1, 10):
        mask = mask_of(CAMERAS[0], body(second))
        whole.append(Silhouette.of(mask, CAMERAS[0]))
        rows = np.flatnonzero(mask.any(axis=1))
        moved = np.zeros_like(mask)
        moved[: 240 - rows[0] - 20] = mask[rows[0] + 20 :]  # 20 rows leave the picture at its top
        cut.append((moved, rows[0] + 20))
    lower = Rig.of(CAMERAS)
    for shape, (moved, rows) in zip(whole, cut, strict=True):
        lower.intrinsics[0, 1, 2] = 120.0 - rows
        part = Silhouette.of(moved, CAMERAS[0])
        assert part is not None
        assert shape is not None
        assert SilhouettePair(Silhouettes.of([[part]]), SECOND).error(lower, 0, 1) < FAR
        assert not part.inside.all()


def test_a_body_that_one_camera_does_not_see_is_no_contradiction() -> None:
    """Two people; the second camera sees the first one alone, as the other is beside its picture."""
    seconds = np.linspace(0, 1, MOMENTS)
    both = [mask_of(CAMERAS[0], body(second)) | mask_of(CAMERAS[0], body(second, side=-1.0)) for second in seconds]
    first = Silhouettes.of([silhouettes_of(mask, CAMERAS[0]) for mask in both])
    assert SilhouettePair(first, shapes_of(1)).error(Rig.of(CAMERAS), 0, 1) < 2


def test_moments_may_be_moved_against_each_other() -> None:
    rig = Rig.of(CAMERAS)
    late = [
        silhouettes_of(mask_of(CAMERAS[0], body(max(0, m - 3) / (MOMENTS - 1))), CAMERAS[0]) for m in range(MOMENTS)
    ]
    pair = SilhouettePair(Silhouettes.of(late), shapes_of(1))
    errors = pair.errors(rig, 0, 1, range(-4, 5))
    assert int(errors.argmin()) == 4 + 3
    assert errors[7] < 1.5
    assert pair.error(rig, 0, 1) == errors[4]
    assert SilhouettePair(pair.first, pair.second, 3).error(rig, 0, 1) == errors[7]


def test_too_few_moments_tell_nothing() -> None:
    some = Silhouettes.of([[]] * 20 + [silhouettes_of(mask_of(CAMERAS[0], body(0.5)), CAMERAS[0])] * 4)
    pair = SilhouettePair(some, shapes_of(1))
    assert (pair.weight, pair.tells) == (4, False)
    assert np.isnan(pair.errors(Rig.of(CAMERAS), 0, 1, [0]))
    nothing = SilhouettePair(Silhouettes.of([[]] * MOMENTS), shapes_of(1))
    assert nothing.weight == pytest.approx(0)
    assert nothing.error(Rig.of(CAMERAS), 0, 1) == 0
