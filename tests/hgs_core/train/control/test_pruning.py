"""Splats that nobody needs are removed."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from hgs_core.scene.splats import StaticSplats
from hgs_core.train.control import pruning
from hgs_core.train.control.pruning import PruningRound
from hgs_core.train.splat_sets import joined
from tests.hgs_core.train.conftest import CONFIG, state_of
from tests.synthetic import synthetic_scene
from tests.worker_threads import threads_of


def test_splats_that_no_view_needs_are_removed_and_the_others_kept(applied: Callable[..., None]) -> None:
    static, dynamic = synthetic_scene()
    hidden = static.take(slice(0, 5))
    behind = StaticSplats(hidden.means + 100, hidden.log_scales, hidden.quats, hidden.opacity_logits, hidden.rgb)
    state = state_of(joined(static, behind), dynamic)
    applied(PruningRound(CONFIG), state)
    assert len(static) * 0.9 < len(state.static) <= len(static)
    assert float(state.static.means.abs().max()) < 50
    assert len(state.dynamic) == len(dynamic)
    assert state.history.pruned == len(static) + 5 - len(state.static)


def test_statics_that_do_not_learn_are_not_pruned(applied: Callable[..., None]) -> None:
    static, dynamic = synthetic_scene()
    far = StaticSplats(static.means + 100, static.log_scales, static.quats, static.opacity_logits, static.rgb)
    state = state_of(far, dynamic)
    applied(PruningRound(CONFIG), state, statics_learn=False)
    assert len(state.static) == len(far)


def test_cameras_are_weighed_on_all_cores(applied: Callable[..., None], monkeypatch: pytest.MonkeyPatch) -> None:
    threads = threads_of(monkeypatch, pruning, "FixedView")
    applied(PruningRound(CONFIG), state_of(*synthetic_scene()))
    assert threads
    assert "MainThread" not in threads
