"""Curves and profile of a training run."""

from __future__ import annotations

import math
from itertools import pairwise

from hgs_core.train.history import TrainingHistory


def test_nothing_is_reported_before_the_first_loss() -> None:
    history = TrainingHistory()
    history.report(10, 0.1, 5, 6)
    assert history.curves["iteration"] == []
    assert math.isnan(history.psnr)


def test_a_report_adds_a_point_to_every_curve() -> None:
    history = TrainingHistory()
    history.follow(0.5, 20.0)
    history.follow(0.4, 30.0)
    history.report(10, 0.1, 5, 6)
    assert history.curves["loss"] == [0.9 * 0.5 + 0.1 * 0.4]
    assert history.curves["psnr"] == [21.0]
    assert [history.curves[name] for name in ("iteration", "seconds", "static", "dynamic")] == [[10], [0.1], [5], [6]]


def test_curves_stay_short_and_evenly_spaced() -> None:
    history = TrainingHistory()
    history.follow(0.5, 20.0)
    for iteration in range(1, 5001):
        history.report(iteration, 0.0, 1, 1)
    iterations = history.curves["iteration"]
    assert len(iterations) <= 1000
    assert {b - a for a, b in pairwise(iterations)} == {float(history.stride)}
    assert iterations[-1] > 5000 - history.stride


def test_time_adds_up_by_activity() -> None:
    history = TrainingHistory()
    for _ in range(2):
        with history.timed("labels"):
            pass
    assert set(history.profile) == {"labels"}
    assert history.profile["labels"] > 0


def test_a_restored_history_goes_on_as_the_old_one() -> None:
    history = TrainingHistory()
    history.follow(0.5, 20.0)
    history.relabelled(3, 4)
    for iteration in range(1500):
        history.report(iteration, 0.0, 1, 1)
    restored = TrainingHistory.restored(history.state())
    for one in (history, restored):
        one.report(1500, 0.0, 1, 1)
        one.report(1501, 0.0, 1, 1)
    assert restored.state() == history.state()
