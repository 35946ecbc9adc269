"""The remaining time of a whole training."""

from __future__ import annotations

import dataclasses

import pytest

from hgs_core.base.progress import Progress
from hgs_core.runs.remaining_time import RemainingTime
from hgs_core.runs.training_need import TrainingNeed

NEED = TrainingNeed({"train": 1}, 0, 0, {"points": 100.0, "train": 1000.0, "encode": 50.0}, (0.5, 1.0))


@pytest.fixture
def forecast(monkeypatch: pytest.MonkeyPatch) -> RemainingTime:
    monkeypatch.setenv("HGS_THREADS", "1")
    return RemainingTime(NEED)


def after(forecast: RemainingTime, *reports: tuple[str, int, float]) -> float | None:
    """Return the remaining seconds after the last of reports of 100 units each."""
    return [forecast.after(Progress(stage, done, 100), now) for stage, done, now in reports][-1]


def test_at_first_it_is_what_was_predicted(forecast: RemainingTime) -> None:
    assert after(forecast, ("points", 0, 0.0)) == pytest.approx(1150)


def test_later_stages_count_before_they_begin(forecast: RemainingTime) -> None:
    assert after(forecast, ("points", 0, 0.0), ("points", 100, 100.0)) == pytest.approx(1050)


def test_a_machine_of_half_the_speed_takes_twice_as_long(forecast: RemainingTime) -> None:
    left = after(forecast, ("points", 0, 0.0), ("points", 50, 100.0))
    assert left == pytest.approx(2 * 1100, rel=0.15)


def test_the_pace_of_earlier_stages_holds_for_the_next(forecast: RemainingTime) -> None:
    left = after(forecast, ("points", 0, 0.0), ("points", 100, 300.0), ("train", 0, 300.0))
    assert left == pytest.approx(3 * 1050, rel=0.15)


def test_iterations_count_by_their_cost(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HGS_THREADS", "1")
    dear_at_the_end = RemainingTime(dataclasses.replace(NEED, course=(0.1, 1.0)))
    left = after(dear_at_the_end, ("train", 0, 0.0), ("train", 50, 100.0))
    assert left == pytest.approx(900 + 50)


def test_a_resumed_stage_has_the_rest_alone_before_it(forecast: RemainingTime) -> None:
    assert after(forecast, ("train", 80, 0.0)) == pytest.approx(200 + 50)


def test_only_the_last_five_minutes_tell_the_pace_of_a_stage(forecast: RemainingTime) -> None:
    reports = [("train", done, 10.0 * done) for done in range(41)]
    slow = [("train", 40 + step, 400.0 + 40 * step) for step in range(1, 21)]  # then a quarter as fast
    assert after(forecast, *reports, *slow) == pytest.approx(4 * 400, rel=0.15)


def test_a_stage_that_nobody_predicted_goes_on_as_it_did(forecast: RemainingTime) -> None:
    left = after(forecast, ("cameras", 0, 0.0), ("cameras", 20, 60.0))
    assert left == pytest.approx(240 + 1150)


def test_without_a_prediction_the_stage_alone_is_known() -> None:
    assert after(RemainingTime(None), ("sync", 0, 0.0), ("sync", 50, 10.0)) == pytest.approx(10)


@pytest.mark.parametrize(
    "reports",
    [
        [("sync", 0, 0.0)],
        [("sync", 0, 0.0), ("sync", 2, 4.9)],  # too early
        [("sync", 5, 0.0), ("sync", 5, 60.0)],  # it stands still
        [("sync", 50, 0.0), ("sync", 10, 60.0)],  # begun again
    ],
)
def test_without_a_prediction_it_may_be_unknown(reports: list[tuple[str, int, float]]) -> None:
    assert after(RemainingTime(None), *reports) is None
