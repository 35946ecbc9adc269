"""The report of a benchmark, on scenes too small for figures of speed."""

from __future__ import annotations

import json

import pytest

from hgs_core.base.progress import Progress
from hgs_core.bench.raster.raster_bench import STAGES, RasterReport
from hgs_core.native import library

needs_kernels = pytest.mark.skipif(not library.available(), reason="hgs was built without its C++ kernels")


def test_every_point_of_the_matrix_is_there_once(report: RasterReport) -> None:
    found = [(p.size, p.backend, p.threads) for p in report.points]
    expected = {("300@64x48", backend, threads) for backend in report.settings.backends for threads in (1, 2)}
    if library.available():
        expected |= {("400@75x41", "cpu", threads) for threads in (1, 2)}
    assert set(found) == expected
    assert len(found) == len(expected)


def test_progress_counts_the_points(report: RasterReport, heard: list[Progress]) -> None:
    assert [p.done for p in heard] == list(range(1, len(report.points) + 1))
    assert {p.total for p in heard} == {len(report.points)}


def test_errors_are_those_of_the_truth_sizes(report: RasterReport) -> None:
    for p in report.points:
        assert (p.errors is not None) == (p.size == "300@64x48")
        if p.errors is not None:
            assert p.errors.image < 1e-4
            assert max(p.errors.gradients.values()) < 1e-3


def test_reference_has_no_stages_within_its_forward_pass(report: RasterReport) -> None:
    for p in report.points:
        assert tuple(p.stages) == STAGES
        missing = [name for name, seconds in p.stages.items() if seconds is None]
        assert missing == ([] if p.backend == "cpu" else ["project", "bin"])


@needs_kernels
def test_work_is_the_same_for_any_number_of_threads(report: RasterReport) -> None:
    for size in {p.size for p in report.points}:
        work = [p.work for p in report.points if p.size == size and p.backend == "cpu" and p.work is not None]
        assert len(work) == 2
        assert len({(w.visible_static, w.visible_dynamic, w.tile_entries, w.evaluations) for w in work}) == 1
        assert work[0].visible_dynamic > 0


@needs_kernels
def test_rates_are_evaluations_over_the_time_of_compositing(report: RasterReport) -> None:
    for p in report.points:
        if p.work is None or p.backward_parts is None:
            continue
        seconds = {"forward": p.stages["forward"], "backward": p.backward_parts["composite_backward"]}
        operations = {"forward": report.operations.forward, "backward": report.operations.backward}
        for part, rate in p.work.evaluations_per_second.items():
            assert rate == pytest.approx(p.work.evaluations / seconds[part])  # type: ignore[operator]
            share = rate * operations[part] / report.fma_peaks[p.threads]
            assert p.work.share_of_peak[part] == pytest.approx(share)


@needs_kernels
def test_speedup_is_the_ratio_of_drawing_and_differentiating(report: RasterReport) -> None:
    times = {(p.size, p.backend, p.threads): p.forward_backward for p in report.points}
    assert [(s.size, s.threads) for s in report.speedups] == [("300@64x48", 1), ("300@64x48", 2)]
    for s in report.speedups:
        ratio = times[s.size, "reference", s.threads] / times[s.size, "cpu", s.threads]
        assert s.reference_over_cpu == pytest.approx(ratio)


def test_scaling_compares_with_the_fewest_threads(report: RasterReport) -> None:
    points = {(p.size, p.backend, p.threads): p for p in report.points}
    assert len(report.scaling) == len(points) / 2
    for s in report.scaling:
        assert (s.threads, s.against) == (2, 1)
        one, two = points[s.size, s.backend, 1], points[s.size, s.backend, 2]
        assert s.iteration == pytest.approx(one.iteration / two.iteration)
        assert s.stages["loss"] == pytest.approx(one.stages["loss"] / two.stages["loss"])  # type: ignore[operator]


def test_report_is_plain_json(report: RasterReport) -> None:
    plain = json.loads(json.dumps(report.to_json(), allow_nan=False))
    assert plain["settings"]["sizes"] == ["300@64x48", "400@75x41"]
    assert plain["machine"]["instruction_set"] == library.instruction_set()
    assert [p["size"] for p in plain["points"]] == [p.size for p in report.points]
    assert plain["points"][0]["stages"]["loss"] == report.points[0].stages["loss"]
