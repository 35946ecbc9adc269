from __future__ import annotations

import pytest

from hgs_core.base.progress import Progress, StageStopped
from server.cli.interrupts import Interrupts
from server.cli.progress_bars import ProgressBars


def drawn(capsys: pytest.CaptureFixture[str], *reports: Progress) -> list[str]:
    """Return the bars as they stand at the end, one for each stage."""
    with ProgressBars() as bars:
        for report in reports:
            bars(report)
    output = capsys.readouterr()
    assert output.out == ""
    return [line.rpartition("\r")[2] for line in output.err.rstrip("\n").split("\n")]


def test_a_bar_shows_its_stage_and_how_far_it_is(capsys: pytest.CaptureFixture[str]) -> None:
    (bar,) = drawn(capsys, Progress("train", 1, 9), Progress("train", 3, 9))
    assert bar.startswith("train")
    assert "3/9" in bar


def test_each_stage_has_a_bar_of_its_own(capsys: pytest.CaptureFixture[str]) -> None:
    first, second = drawn(capsys, Progress("initialise", 2, 2), Progress("train", 1, 5))
    assert first.startswith("initialise")
    assert "2/2" in first
    assert second.startswith("train")
    assert "1/5" in second


def test_figures_are_whole_or_have_four_digits(capsys: pytest.CaptureFixture[str]) -> None:
    (bar,) = drawn(capsys, Progress("train", 1, 2, {"psnr": 27.12567, "splats": 123456.0}))
    assert "psnr=27.13, splats=123456" in bar


def test_the_rest_of_everything_comes_before_the_figures(capsys: pytest.CaptureFixture[str]) -> None:
    with ProgressBars() as bars:
        bars(Progress("train", 1, 2, {"psnr": 27.0}), 4000.0)
    assert "left=1 h 6 min, psnr=27" in capsys.readouterr().err


def test_a_total_that_grows_is_followed(capsys: pytest.CaptureFixture[str]) -> None:
    (bar,) = drawn(capsys, Progress("frames", 1, 2), Progress("frames", 2, 8))
    assert "2/8" in bar


def test_a_stage_that_is_resumed_goes_on_where_it_was(capsys: pytest.CaptureFixture[str]) -> None:
    """Its speed is that of this process, so the bar begins with earlier work."""
    (bar,) = drawn(capsys, Progress("train", 800, 1000))
    assert "800/1000" in bar
    assert "?it/s" in bar  # nothing was done yet while this process looked


def test_an_interrupt_stops_the_stage_at_its_next_report() -> None:
    interrupts = Interrupts()
    with ProgressBars(interrupts) as bars:
        bars(Progress("train", 1, 2))
        interrupts.pending = True
        with pytest.raises(StageStopped):
            bars(Progress("train", 2, 2))
