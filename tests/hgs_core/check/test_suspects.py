from __future__ import annotations

from hgs_core.check.epipolar import pair_errors
from hgs_core.check.suspects import find_suspects
from tests.rigs import rig_and_matches


def test_in_a_right_rig_all_cameras_agree() -> None:
    rig, pairs = rig_and_matches()
    found = find_suspects(8, pair_errors(rig, pairs), pairs)
    assert found.agreeing == tuple(range(8))
    assert not found.odd
    assert not found.whole_rig
    assert max(error or 0.0 for error in found.errors) < 0.5


def test_the_camera_with_a_wrong_focal_length_is_odd_and_the_others_keep_small_errors() -> None:
    rig, pairs = rig_and_matches(4)
    rig = rig.with_focal(2.0, camera=2)
    found = find_suspects(4, pair_errors(rig, pairs), pairs)
    assert found.odd == (2,)
    assert (found.errors[2] or 0.0) > 3
    assert all((found.errors[i] or 0.0) < 0.5 for i in (0, 1, 3))


def test_where_all_are_wrong_nobody_is_odd() -> None:
    rig, pairs = rig_and_matches()
    rig = rig.rearranged([3, 1, 6, 0, 7, 2, 4, 5])
    found = find_suspects(8, pair_errors(rig, pairs), pairs)
    assert found.whole_rig
    assert not found.odd


def test_a_camera_that_shares_no_view_is_not_judged() -> None:
    rig, pairs = rig_and_matches()
    pairs = {pair: one for pair, one in pairs.items() if 5 not in pair}
    found = find_suspects(8, pair_errors(rig, pairs), pairs)
    assert found.unjudged == (5,)
    assert found.errors[5] is None
    assert not found.whole_rig


def test_one_pair_of_chance_matches_makes_no_camera_odd() -> None:
    rig, pairs = rig_and_matches()
    errors = pair_errors(rig, pairs) | {(0, 4): 60.0}
    assert not find_suspects(8, errors, pairs).odd
