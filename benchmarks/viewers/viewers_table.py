"""The viewers' figures as text for people."""

from __future__ import annotations

from collections.abc import Mapping

from benchmarks.viewers.viewers_bench import DEGREES, ViewerPoint, ViewerReport
from hgs_core.bench.raster.raster_table import aligned

__all__ = ["viewer_line", "viewers_text"]

PHASES = ("still", "orbit")


def viewers_text(report: ViewerReport) -> str:
    """Return the table of a report: times, as ratios to the fastest of the other viewers too, and errors."""
    machine, (width, height) = report.machine, report.size
    others = [point for point in report.points if not point.viewer.startswith("hgs")]
    fastest = {phase: min((getattr(p, phase) for p in others), default=None) for phase in PHASES}
    header = ["viewer", "still", "x", "orbit", "x", "playing", *(f"PSNR at {degrees}°" for degrees in DEGREES)]
    rows = [header, *(_row(point, fastest) for point in report.points)]
    drawn = f"{report.rounds} rounds of {report.frames} frames a phase"
    lines = [
        f"{machine['cpu']}, {machine['cores']} cores, load {machine['load']}, Chromium {report.chromium}",
        f"{report.source}: {report.splats:,} splats, {width}x{height}, {drawn}",
        "Milliseconds of processor time for each frame (median of the rounds), x: over the fastest of the others; dB",
        "",
        *aligned(rows, left=("viewer",)),
    ]
    return "\n".join(lines)


def viewer_line(point: ViewerPoint, rounds: int, of: int) -> str:
    """Return a viewer's figures so far as one line, after some rounds of all."""
    phases = ", ".join(f"{phase} {getattr(point, phase):.0f} ms" for phase in PHASES)
    playing = "" if point.playing is None else f", playing {point.playing:.0f} ms"
    return f"{point.viewer}: {phases}{playing}, {min(point.psnr):.1f} dB at worst (round {rounds} of {of})"


def _row(point: ViewerPoint, fastest: Mapping[str, float | None]) -> list[str]:
    cells = [point.viewer]
    for phase in PHASES:
        value, least = getattr(point, phase), fastest[phase]
        cells += [f"{value:.0f}", "-" if least is None else f"{value / least:.2f}"]
    playing = "-" if point.playing is None else f"{point.playing:.0f}"
    return [*cells, playing, *(f"{error:.1f}" for error in point.psnr)]
