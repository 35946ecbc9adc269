"""The report of a soak: verdict, faults, waits and curves, as a page of HTML and as JSON."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, astuple, dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any

from benchmarks.soak.curve_slopes import LIMITS, Slope
from benchmarks.soak.history_check import Finding
from benchmarks.soak.process_curves import Sample
from benchmarks.soak.request_history import Act, Event
from hgs_core.report.charts import Series, line_chart
from hgs_core.report.markup import chart, note, pairs, section, table

__all__ = ["SoakResult", "waits_of", "write_report"]

_UNITS = {"memory": "MiB", "files": "open files", "threads": "threads", "connections": "connections"}


@dataclass(frozen=True)
class SoakResult:
    """Everything that a soak has brought."""

    facts: Mapping[str, Any]  # seed, minutes, jobs and the like
    findings: Sequence[Finding]
    slopes: Sequence[Slope]
    faults: Mapping[str, int]
    waits: Mapping[str, float]
    missing: Sequence[str]

    @property
    def steep(self) -> list[Slope]:
        """The slopes above their limits."""
        return [slope for slope in self.slopes if slope.too_steep]

    @property
    def sound(self) -> bool:
        """Whether work was done, every promise was kept and nothing grew."""
        return bool(self.facts.get("succeeded")) and not self.findings and not self.steep

    def lines(self) -> list[str]:
        """Return the verdict for a terminal."""
        found = [f"{finding.verdict}: {finding.subject}" for finding in self.findings]
        found += [f"{one.role}: {one.measure} grow by {one.per_minute:.2f} a minute" for one in self.steep]
        found += [] if self.facts.get("succeeded") else ["no job succeeded: nothing was shown"]
        told = [f"{sum(self.faults.values())} faults: " + ", ".join(f"{n} {kind}" for kind, n in self.faults.items())]
        told += [", ".join(f"{name} {value}" for name, value in self.facts.items())]
        told += [", ".join(f"{name} {value:.1f} s" for name, value in self.waits.items())]
        return [*told, *self.missing, *(found or ["sound: every promise was kept, nothing grew"])]


def waits_of(history: Sequence[Event]) -> dict[str, float]:
    """Return the waits of viewers and jobs in seconds; a viewer without a picture has waited until it left."""
    watched = [event for event in history if event.act is Act.WATCH and event.acknowledged]
    starts = sorted(e.request["seconds"] if (start := e.answer["start"]) is None else start for e in watched)
    submitted = {e.answer["id"]: e.ended for e in reversed(history) if e.act is Act.SUBMIT and e.acknowledged}
    ended = [
        event.ended - submitted[event.target]
        for event in history
        if event.act is Act.SEE and event.answer.get("state") == "succeeded" and event.target in submitted
    ]
    return {
        "first picture (median)": starts[len(starts) // 2] if starts else 0.0,
        "first picture (longest)": max(starts, default=0.0),
        "longest stall": max((event.answer["waited"] for event in watched), default=0.0),
        "all stalls": sum(event.answer["waited"] for event in watched),
        "longest job": max(ended, default=0.0),
    }


def write_report(
    folder: Path,
    result: SoakResult,
    samples: Mapping[str, Sequence[Sample]],
    disk: Mapping[str, Sequence[tuple[float, float]]],
) -> Path:
    """Write report.html, report.json and curves.json, and return the page."""
    (folder / "report.json").write_text(json.dumps(asdict(result), indent=1))
    curves = {role: [astuple(sample) for sample in points] for role, points in samples.items()}
    (folder / "curves.json").write_text(json.dumps({"processes": curves, "disk": disk}))
    charts = [chart(unit, _curves(measure, unit, samples), _limit(measure)) for measure, unit in _UNITS.items()]
    lines = [Series(name, *_columns(points), number) for number, (name, points) in enumerate(disk.items())]
    charts.append(chart("Disk", line_chart("Disk", lines, "seconds", "MiB", y_zero=True)))
    rows = [
        (slope.role, slope.measure, "-" if slope.per_minute is None else f"{slope.per_minute:+.2f}")
        for slope in result.slopes
    ]
    html = [
        section("verdict", "Verdict", [note(line) for line in result.lines()]),
        section("waits", "Waits", [pairs({name: f"{value:.1f} s" for name, value in result.waits.items()})]),
        section("curves", "Curves", charts),
        section("slopes", "Growth", [table("Growth per minute", ("process", "measure", "per minute"), rows)]),
    ]
    css = files("hgs_core.report").joinpath("page.css").read_text()
    page = folder / "report.html"
    page.write_text(
        f'<!doctype html><html lang="en"><meta charset="utf-8"><title>Soak</title><style>{css}</style>'
        f"<main><h1>Soak</h1>{''.join(html)}</main></html>"
    )
    return page


def _curves(measure: str, unit: str, samples: Mapping[str, Sequence[Sample]]) -> str:
    lines = []
    for number, (role, points) in enumerate(samples.items()):
        values = [float(getattr(sample, measure)) for sample in points]
        lines.append(Series(role, [sample.time for sample in points], values, number))
    return line_chart(measure, lines, "seconds", unit, y_zero=True)


def _limit(measure: str) -> str:
    return f"Growth above {LIMITS[measure]:g} a minute fails."


def _columns(points: Sequence[tuple[float, float]]) -> tuple[list[float], list[float]]:
    return [time for time, _ in points], [value for _, value in points]
