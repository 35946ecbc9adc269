"""Comparisons of two checkouts as text."""

from __future__ import annotations

from collections.abc import Sequence

from benchmarks.against.comparison import Comparison
from hgs_core.bench.raster.raster_table import aligned, milliseconds
from hgs_core.bench.raster.stage_times import TrainingTimes

__all__ = ["comparison_text"]


def comparison_text(comparisons: Sequence[Comparison]) -> str:
    """Return the tables of times and, where they were measured, of errors."""
    lines = ["Milliseconds of processor time, in turn", *_aligned(_times(comparisons))]
    if len(rows := _errors(comparisons)) > 1:
        lines += ["", "Relative L2 error of both against the float64 reference", *_aligned(rows)]
    return "\n".join(lines)


def _aligned(rows: list[list[str]]) -> list[str]:
    return aligned(rows, left=("size", "checkout"))


def _times(comparisons: Sequence[Comparison]) -> list[list[str]]:
    rows = [["size", "threads", "checkout", *TrainingTimes._fields]]
    for c in comparisons:
        for name, times in (("this one", c.here), ("other", c.other)):
            rows.append([c.size, str(c.threads), name, *map(milliseconds, times)])
        bounds = zip(c.speed, c.slowest, c.fastest, strict=True)
        ratios = (f"{middle:.2f} ({least:.2f}-{most:.2f})" for middle, least, most in bounds)
        rows.append([c.size, str(c.threads), "times as fast", *ratios])
    return rows


def _errors(comparisons: Sequence[Comparison]) -> list[list[str]]:
    rows: dict[tuple[str, str], list[str]] = {}
    names: list[str] = []
    for c in comparisons:
        for checkout, errors in (("this one", c.errors_here), ("other", c.errors_other)):
            if errors is not None:
                names = list(errors)
                rows[c.size, checkout] = [c.size, checkout, *(f"{figure:.1e}" for figure in errors.values())]
    return [["size", "checkout", *names], *rows.values()]
