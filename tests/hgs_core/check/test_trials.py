from __future__ import annotations

import numpy as np

from hgs_core.check.epipolar import Rig
from hgs_core.check.trials import Cause, Correction, Trial, best_trial, fitting
from tests.rigs import dome

RIG = Rig.of(dome(4))
ROLLED = Rig(RIG.intrinsics, np.diag((-1.0, -1.0, 1.0, 1.0)) @ RIG.poses)
MOVED = Rig(RIG.intrinsics, RIG.poses @ np.diag((-1.0, -1.0, 1.0, 1.0)))  # the world is turned, the rig is the same


def test_what_fits_is_near_and_much_nearer_than_before() -> None:
    assert fitting(1.0, 20.0, 1.5)
    assert not fitting(1.0, 2.0, 1.5)
    assert not fitting(2.0, 20.0, 1.5)


def test_the_trial_with_the_least_error_is_the_best_and_a_rare_one_needs_less() -> None:
    trials = [Trial(RIG, "usual", ""), Trial(ROLLED, "rare", "", cost=3.0)]
    assert best_trial(trials, 20.0, [0.5, 1.0]) == 0
    assert best_trial(trials, 20.0, [1.2, 0.1]) == 1
    assert best_trial(trials, 20.0, [0.6, 0.4]) == 0


def test_of_two_that_fit_alike_none_is_named_unless_they_are_one_rig() -> None:
    assert best_trial([Trial(RIG, "one", ""), Trial(ROLLED, "other", "")], 20.0, [0.5, 0.6]) is None
    assert best_trial([Trial(RIG, "one", ""), Trial(MOVED, "other", "")], 20.0, [0.5, 0.6]) == 0


def test_a_cause_knows_what_each_camera_is_to_have() -> None:
    order = (1, 0, 2, 3)
    swapped = Trial(RIG.rearranged(order).with_focal(2.0, 2), "swapped, and longer", "", order=order).cause(RIG, 0.3)
    assert {camera: (one.calibration, one.focal) for camera, one in swapped.corrections.items()} == {
        0: (1, 1.0),
        1: (0, 1.0),
        2: (2, 2.0),
    }
    np.testing.assert_array_equal(swapped.corrections[0].pose, RIG.poses[1])
    assert not Trial(ROLLED, "about so", "", exact=False).cause(RIG, 0.3).corrections


def test_a_finding_says_how_it_can_be_corrected_if_it_can() -> None:
    told = Cause("it is turned", "turn it", 0.25).finding(True, ("a",), "it lies 9 px off", "ab", digits=2)
    assert told.sentence() == "a: it lies 9 px off: it is turned (0.25 px then); turn it"
    cause = Cause("it is turned", "turn it", corrections={1: Correction(np.eye(4), 0, 1.0)})
    fixed = cause.finding(True, ("b",), "it lies 9 px off", "ab")
    assert fixed.cure == "turn it, or let hgs check --fix-poses write poses.json"
    assert [(one.name, one.calibration) for one in fixed.corrected] == [("b", "a")]
