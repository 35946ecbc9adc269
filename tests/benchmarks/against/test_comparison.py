"""Comparing two checkouts, where both are this one."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from benchmarks.against.comparison import Comparison, compare, interpreter_of
from hgs_core.base.errors import InputError
from hgs_core.bench.raster.raster_settings import BenchSettings
from hgs_core.bench.raster.raster_sizes import Size
from hgs_core.bench.raster.stage_times import TrainingTimes
from hgs_core.native import library

SIZE = Size(200, 40, 24)
needs_kernels = pytest.mark.skipif(not library.available(), reason="hgs was built without its C++ kernels")


@pytest.fixture(scope="module")
def comparison() -> Comparison:
    settings = BenchSettings.of(sizes=(SIZE,), threads=(1,), seconds=1e-3, backends=("cpu",))
    return compare(settings, Path(sys.executable), SIZE, 1, rounds=3)


@needs_kernels
def test_both_are_timed_and_the_ratio_lies_between_those_of_the_rounds(comparison: Comparison) -> None:
    assert (comparison.size, comparison.threads, comparison.rounds) == ("200@40x24", 1, 3)
    assert min(*comparison.here, *comparison.other) > 0
    for name in TrainingTimes._fields:
        least, middle, most = (
            getattr(times, name) for times in (comparison.slowest, comparison.speed, comparison.fastest)
        )
        assert 0 < least <= middle <= most


@needs_kernels
def test_errors_of_the_same_code_are_the_same(comparison: Comparison) -> None:
    assert comparison.errors_here == comparison.errors_other
    assert comparison.errors_here is not None
    assert 0 < comparison.errors_here["image"] < 1e-4
    assert "static.means" in comparison.errors_here


def test_a_checkout_that_is_not_installed_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"run scripts/install there"):
        interpreter_of(tmp_path)


@needs_kernels
def test_an_interpreter_that_does_not_measure_is_refused(tmp_path: Path) -> None:
    broken = tmp_path / ".venv" / "bin" / "python"
    broken.parent.mkdir(parents=True)
    broken.write_text("#!/bin/sh\nexit 1\n")
    broken.chmod(0o755)
    settings = BenchSettings.of(sizes=(SIZE,), threads=(1,), seconds=1e-3, backends=("cpu",))
    with pytest.raises(InputError, match="could not measure"):
        compare(settings, interpreter_of(tmp_path), SIZE, 1)
