from __future__ import annotations

import pytest

from hgs_core.check.epipolar import Pair, Rig, pair_errors
from hgs_core.check.evidence import Evidence
from hgs_core.check.shown_pairs import shown_pairs
from hgs_core.check.suspects import find_suspects


def shown(seen: Evidence, rig: Rig):  # type: ignore[no-untyped-def]
    pairs = {pair: Pair.of(matches) for pair, matches in seen.pairs.items()}
    errors = pair_errors(rig, pairs)
    return shown_pairs(seen, rig, errors, find_suspects(len(seen.cameras), errors, pairs))


def test_the_odd_camera_is_shown_with_matches_beside_their_lines(studio_evidence: Evidence) -> None:
    rig = Rig.of(studio_evidence.cameras).with_focal(2.0, 2)
    (pair,) = shown(studio_evidence, rig)
    assert studio_evidence.cameras[2].name in pair.cameras
    assert pair.error > 3
    assert max(abs(a * m.second[0] + b * m.second[1] + c) for m in pair.matches for a, b, c in [m.line]) > 3


def test_of_a_right_rig_one_pair_is_shown_with_matches_on_their_lines(studio_evidence: Evidence) -> None:
    (pair,) = shown(studio_evidence, Rig.of(studio_evidence.cameras))
    assert len(pair.matches) >= 5
    for match in pair.matches:
        a, b, c = match.line
        assert a * match.second[0] + b * match.second[1] + c == pytest.approx(0, abs=3)
