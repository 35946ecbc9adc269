from __future__ import annotations

import dataclasses

from hgs_core.bench.raster.raster_bench import RasterReport
from hgs_core.bench.raster.raster_table import aligned, report_text


def table(text: str, title: str) -> list[list[str]]:
    """The rows of a table of the text, cell by cell; without its header."""
    part = next(part for part in text.split("\n\n") if part.startswith(title))
    return [line.split() for line in part.splitlines()[2:]]


def test_names_are_aligned_to_the_left_and_figures_to_the_right() -> None:
    rows = [["size", "ms", "backend"], ["7@8x9", "1.25", "cpu"], ["20k@8x9", "100", "reference"]]
    assert aligned(rows, left=("size", "backend")) == [
        "size       ms  backend  ",
        "7@8x9    1.25  cpu      ",
        "20k@8x9   100  reference",
    ]


def test_there_is_a_row_of_times_for_every_point_in_milliseconds(report: RasterReport) -> None:
    rows = table(report_text(report), "Milliseconds")
    assert [tuple(row[:3]) for row in rows] == [(p.size, p.backend, str(p.threads)) for p in report.points]
    point = dataclasses.replace(report.points[0], iteration=0.0125, iteration_least=0.25)
    (row,) = table(report_text(dataclasses.replace(report, points=(point,))), "Milliseconds")
    assert row[-3:-1] == ["12.50", "250"]  # no decimals above a tenth of a second


def test_a_table_without_rows_is_left_out(report: RasterReport) -> None:
    bare = dataclasses.replace(report, points=report.points[:1], speedups=(), scaling=())
    titles = [part.splitlines()[0] for part in report_text(bare).split("\n\n")]
    assert "Times as fast with more threads" not in titles
    assert any(title.startswith("Milliseconds") for title in titles)


def test_speedups_and_scaling_are_ratios_without_units(report: RasterReport) -> None:
    (scaling, *_) = report.scaling
    only = dataclasses.replace(report, scaling=(dataclasses.replace(scaling, iteration=1.4142),))
    (row,) = table(report_text(only), "Times as fast with more threads")
    assert row[:2] == [scaling.size, scaling.backend]
    assert (" ".join(row[2:5]), row[-1]) == ("2 against 1", "1.41")
