"""A benchmark's results as text for people."""

from __future__ import annotations

from collections.abc import Container, Iterable, Sequence

from hgs_core.base.wording import counted
from hgs_core.bench.raster.raster_bench import STAGES, Point, RasterReport

__all__ = ["aligned", "milliseconds", "report_text"]


def report_text(report: RasterReport) -> str:
    """Return the tables of a report: times, work, errors, and the ratios between backends and numbers of threads."""
    machine = report.machine
    kernels = machine["instruction_set"] or "none"
    lines = [
        f"{machine['cpu']}, {machine['cores']} cores, {machine['system']}, kernels {kernels}, torch {machine['torch']}",
        f"load {machine['load']}, seed {report.settings.seed}, {report.settings.dynamic_share:.0%} dynamic splats",
        *(f"FMA peak with {counted(n, 'thread')}: {peak / 1e9:.1f} Gflop/s" for n, peak in report.fma_peaks.items()),
    ]
    tables = [
        ("Milliseconds of a training iteration (median)", _times(report.points)),
        ("Work of the cpu backend; one evaluation is one splat at one pixel", _work(report.points)),
        ("Relative L2 error against the float64 reference", _errors(report.points)),
        ("Times as fast as the batched torch path, forward and backward", _speedups(report)),
        ("Times as fast with more threads", _scaling(report)),
    ]
    for title, rows in tables:
        if len(rows) > 1:
            lines += ["", title, *aligned(rows, left=("size", "backend", "checkout"))]
    return "\n".join(lines)


def _times(points: Iterable[Point]) -> list[list[str]]:
    rows = [["size", "backend", "threads", *STAGES, "iteration", "least", "per second"]]
    for p in points:
        stages = [milliseconds(p.stages[name]) for name in STAGES]
        whole = milliseconds(p.iteration), milliseconds(p.iteration_least), f"{p.iterations_per_second:.1f}"
        rows.append([p.size, p.backend, str(p.threads), *stages, *whole])
    return rows


def _work(points: Iterable[Point]) -> list[list[str]]:
    header = ["size", "threads", "visible", "tile entries", "evaluations"]
    rows = [[*header, "forward G/s", "backward G/s", "forward of peak", "backward of peak"]]
    for p in points:
        if p.work is not None:
            counts = (p.work.visible_static + p.work.visible_dynamic, p.work.tile_entries, p.work.evaluations)
            rates, shares = p.work.evaluations_per_second, p.work.share_of_peak
            rows.append(
                [
                    p.size,
                    str(p.threads),
                    *(f"{count:,}" for count in counts),
                    *(f"{rates[part] / 1e9:.2f}" for part in ("forward", "backward")),
                    *(f"{shares[part]:.0%}" for part in ("forward", "backward")),
                ]
            )
    return rows


def _errors(points: Iterable[Point]) -> list[list[str]]:
    rows: dict[tuple[str, str], list[str]] = {}
    names: list[str] = []
    for p in points:
        if p.errors is not None:
            names = list(p.errors.gradients)
            figures = (p.errors.image, *p.errors.gradients.values())
            rows[p.size, p.backend] = [p.size, p.backend, *(f"{figure:.1e}" for figure in figures)]
    return [["size", "backend", "image", *names], *rows.values()]


def _speedups(report: RasterReport) -> list[list[str]]:
    return [
        ["size", "threads", "cpu over reference"],
        *([s.size, str(s.threads), f"{s.reference_over_cpu:.0f}"] for s in report.speedups),
    ]


def _scaling(report: RasterReport) -> list[list[str]]:
    rows = [["size", "backend", "threads", *STAGES, "iteration"]]
    for s in report.scaling:
        stages = [_figure(s.stages[name]) for name in STAGES]
        rows.append([s.size, s.backend, f"{s.threads} against {s.against}", *stages, _figure(s.iteration)])
    return rows


def milliseconds(seconds: float | None) -> str:
    """Return a time in milliseconds, with decimals below a tenth of a second; "-" for none."""
    return "-" if seconds is None else f"{seconds * 1e3:.2f}" if seconds < 0.1 else f"{seconds * 1e3:.0f}"


def _figure(value: float | None) -> str:
    return "-" if value is None else f"{value:.2f}"


def aligned(rows: Sequence[Sequence[str]], left: Container[str]) -> list[str]:
    """Return rows as lines; columns with titles in `left` are aligned to the left, all others to the right."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    names = [title in left for title in rows[0]]
    return [
        "  ".join(
            cell.ljust(width) if name else cell.rjust(width)
            for cell, width, name in zip(row, widths, names, strict=True)
        )
        for row in rows
    ]
