from __future__ import annotations

from pathlib import Path

import numpy as np

from hgs_core.capture.capture import Capture
from hgs_core.capture.open import open_capture
from hgs_core.check.evidence import Evidence, gather, moments_of
from tests.synthetic import write_capture


def test_moments_are_spread_and_have_a_frame_behind_them(studio: Capture) -> None:
    assert moments_of(studio) == (0, 19, 39, 58)


def test_matches_are_found_without_poses_and_fit_the_true_ones(studio: Capture, studio_evidence: Evidence) -> None:
    from hgs_core.points.features import fundamental_matrix

    assert len(studio_evidence.pairs) >= 8
    for (a, b), matches in studio_evidence.pairs.items():
        x1, x2 = (np.column_stack((xy, np.ones(len(xy)))) for xy in (matches.first, matches.second))
        line = x1 @ fundamental_matrix(studio.cameras[a], studio.cameras[b]).T
        distance = np.abs((line * x2).sum(axis=1)) / np.linalg.norm(line[:, :2], axis=1)
        assert np.median(distance) < 0.6


def test_of_later_moments_only_what_moves_is_matched(studio_evidence: Evidence) -> None:
    view = studio_evidence.views[0]
    assert len(view.features[0].xy) > 1000
    assert all(0 < len(features.xy) < 300 for features in view.features[1:])
    assert view.last is not None
    assert len(view.last.xy) > 1000


def test_large_pictures_are_looked_at_smaller(tmp_path: Path) -> None:
    write_capture(tmp_path, cameras=2, frames=1, width=64, height=48)
    capture = open_capture(tmp_path)
    seen = gather(capture, lambda progress: None, followed=True)
    assert (seen.cameras[0].width, seen.frames) == (64, (0,))
    assert seen.views[0].last is None


def test_what_moves_is_followed_to_the_next_frame_only_if_asked(studio_evidence: Evidence, tmp_path: Path) -> None:
    write_capture(tmp_path, cameras=2, frames=6, width=64, height=48)
    seen = gather(open_capture(tmp_path), lambda progress: None, followed=False)
    assert [view.soon for view in seen.views] == [{}, {}]
    assert all(set(view.soon) == {1, 2} for view in studio_evidence.views)
