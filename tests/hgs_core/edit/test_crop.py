"""Which splats a crop keeps, against the equations of time at many moments of every life."""

from __future__ import annotations

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.edit.crop import crop, paths_inside
from hgs_core.edit.regions import Region, ball_of, box_of
from hgs_core.scene import evaluate, lifetime
from tests.hgs_core.edit.scenes import dynamics, moving, splats

BOX = box_of([0.1, 0, 0, 1.5, 1.6, 1.4, 0.9, 0.1, 0.3, 0.2])
BALL = ball_of([0.1, 0, 0, 0.9])


@pytest.mark.parametrize("region", [BOX, BALL], ids=["box", "ball"])
@pytest.mark.parametrize("coefficients", [4, 6])
def test_paths_are_inside_exactly_where_the_equations_of_time_say_so(region: Region, coefficients: int) -> None:
    dynamic, until = dynamics(np.random.default_rng(1), 400, coefficients), 1.2
    always, ever, seen = paths_inside(dynamic, region, until)
    first, last = lifetime(dynamic)
    first, last = np.maximum(first, 0), np.minimum(last, until)
    np.testing.assert_array_equal(seen, first <= last)
    moments = [np.where(seen, first + (last - first) * share, 0) for share in np.linspace(0, 1, 801)]
    inside = np.array([region.contains(evaluate(dynamic, moment)[0]) for moment in moments])[:, seen]
    assert not (inside.all(axis=0) < always[seen]).any()  # always inside means inside at each moment
    assert not (inside.any(axis=0) > ever[seen]).any()
    assert (inside.all(axis=0) == always[seen]).mean() > 0.99  # others leave between two moments
    assert (inside.any(axis=0) == ever[seen]).mean() > 0.99
    assert 10 < always.sum() < ever.sum() < seen.sum() < len(dynamic)


def test_a_path_that_leaves_for_an_instant_is_not_inside() -> None:
    """A parabola that looks over the border between any two of a few moments."""
    dynamic = dynamics(np.random.default_rng(0), 1)
    dynamic.motion[:] = 0
    dynamic.motion[0, 0, 0], dynamic.motion[0, 2, 0] = 0.5001, -400.0  # x = 0.5001 - 400 d^2
    dynamic.time_centers[:], dynamic.time_log_precisions[:], dynamic.opacity_logits[:] = 0.4637, 4.0, 3.0
    always, ever, seen = paths_inside(dynamic, box_of([-50, 0, 0, 101, 1, 1]), 1.0)
    assert (always.tolist(), ever.tolist(), seen.tolist()) == ([False], [True], [True])
    always, _, _ = paths_inside(dynamic, box_of([-50, 0, 0, 101.001, 1, 1]), 1.0)
    assert always.all()


def test_inside_and_outside_and_what_crosses_are_all_of_the_scene() -> None:
    viewed = moving()
    inside, outside = crop(viewed, BOX), crop(viewed, BOX, inverse=True)
    crossing = [change.count for change in inside.changes if "cross" in change.reason]
    unseen = [change.count for change in inside.changes if "never seen" in change.reason]
    assert splats(inside.viewed) + splats(outside.viewed) + sum(crossing) + sum(unseen) == splats(viewed)
    assert crossing[0] > 5
    assert splats(crop(viewed, BOX, touching=True).viewed) == splats(inside.viewed) + crossing[0]
    static = inside.viewed.scene.static
    np.testing.assert_array_equal(static.means, viewed.scene.static.means[BOX.contains(viewed.scene.static.means)])


def test_it_counts_what_it_leaves_out() -> None:
    viewed = moving()
    edit = crop(viewed, BALL)
    assert sum(change.count or 0 for change in edit.changes) == splats(viewed) - splats(edit.viewed)
    assert "they are not inside of the sphere" in str(edit.changes[0])


def test_a_crop_of_which_nothing_is_left_is_refused() -> None:
    with pytest.raises(InputError, match="--box: no splat of 240 stays inside of the box"):
        crop(moving(), box_of([50, 0, 0, 1, 1, 1]))
