from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from hgs_core.interchange.straight_pieces import MOST, SHARE, Pieces, straight_pieces
from hgs_core.scene import DynamicSplats
from hgs_core.scene.temporal import evaluate, lifetime
from tests.hgs_core.interchange.scenes import axes_of, dynamics


def one(**changed: object) -> DynamicSplats[np.ndarray]:
    """A large opaque splat that stands still for all time, apart from the changes."""
    plain = {
        "motion": np.zeros((1, 4, 3)),
        "rotation": [[[1, 0, 0, 0], [0, 0, 0, 0]]],
        "log_scales": np.zeros((1, 3)),
        "opacity_logits": [4.0],
        "time_centers": [0.5],
        "time_log_precisions": [-20.0],
        "rgb": [[0.5] * 3],
    } | changed
    return DynamicSplats(**{name: np.array(value, np.float32) for name, value in plain.items()})


def shown(pieces: Pieces, time: float) -> np.ndarray:
    return np.flatnonzero((pieces.starts <= time) & (time < pieces.ends))


def test_what_is_straight_is_one_piece_for_all_time_and_exact() -> None:
    motion = np.array([[[1, 2, 3], [0.5, -4, 7], [0, 0, 0], [0, 0, 0]]])
    found = straight_pieces(one(motion=motion))
    assert (found.starts.tolist(), found.ends.tolist()) == ([0], [1])
    np.testing.assert_allclose(found.means, [[1, 2, 3]], atol=1e-12)
    np.testing.assert_allclose(found.velocities, [[0.5, -4, 7]], atol=1e-12)
    assert found.error < 1e-12


def test_every_moment_of_a_life_is_in_one_piece_that_is_near_the_path() -> None:
    """Places, against the equations of time; outlines, by the turn of the longest axis."""
    dynamic = dynamics(60, 5)
    found = straight_pieces(dynamic)
    starts, ends = lifetime(dynamic)
    axes = np.sort(np.exp(dynamic.log_scales), axis=1)
    worst = 0.0
    for time in np.linspace(0, 0.999, 37):
        places, quats, _ = evaluate(dynamic, time)
        rows = shown(found, time)
        which = found.splats[rows]
        assert len(set(which.tolist())) == len(which)
        alive = (starts <= time) & (time <= ends)
        assert set(np.flatnonzero(alive)) <= set(which.tolist())
        rows, which = rows[alive[which]], which[alive[which]]
        center = dynamic.time_centers[which].astype(np.float64)
        off = np.linalg.norm(
            found.means[rows] + found.velocities[rows] * (time - center)[:, None] - places[which], axis=1
        )
        worst = max(worst, off.max(initial=0))
        coarse = found.ends[rows] - found.starts[rows] > 1.5 / MOST
        assert (off[coarse] <= SHARE * axes[which[coarse], 1]).all()
        turn = np.swapaxes(axes_of(found.quats[rows]), 1, 2) @ axes_of(quats[which])
        angles = np.arccos(np.clip((np.trace(turn, axis1=1, axis2=2) - 1) / 2, -1, 1))
        assert (angles[coarse] * axes[which[coarse], 2] <= SHARE * axes[which[coarse], 1] + 1e-6).all()
    assert worst <= found.error * 1.1  # between the samples of a piece


@pytest.mark.parametrize(("bend", "pieces"), [(0.0, 1), (3.9, 1), (4.1, 2), (16.5, 4), (1e6, MOST)])
def test_a_bend_takes_as_few_pieces_as_keep_it_near_its_chords(bend: float, pieces: int) -> None:
    """A path of this second derivative is b h^2 / 8 off its chord of length h: half of an axis of 1 at b = 4 / h^2."""
    motion = np.zeros((1, 4, 3))
    motion[0, 2, 0] = bend / 2
    assert len(straight_pieces(one(motion=motion)).splats) == pieces


def test_a_turn_takes_pieces_as_well() -> None:
    """Of a needle of which nothing moves."""
    turning = one(rotation=[[[1, 0, 0, 0], [0, 0, 0, 1]]], log_scales=[[2, 0, 0]])
    assert len(straight_pieces(turning).splats) > 4


def test_pieces_in_which_nothing_is_seen_are_not_there() -> None:
    """A life of a hundredth at a quarter of the time, on a path that bends, and one that ends before the segment."""
    motion = np.random.default_rng(0).normal(0, 30, (1, 4, 3))
    brief = one(motion=motion, time_centers=[0.26], time_log_precisions=[11.0])
    found = straight_pieces(brief)
    first, last = lifetime(brief)
    assert (found.ends >= first).all()
    assert (found.starts <= last).all()
    gone = dataclasses.replace(brief, time_centers=np.float32([-3.0]))
    assert len(straight_pieces(gone).splats) == 0
    assert len(straight_pieces(DynamicSplats.empty()).splats) == 0
