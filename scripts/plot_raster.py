"""Draw the results of `hgs bench raster --json FILE`: speed against error, and the profile.

    .venv/bin/python scripts/plot_raster.py raster.json raster.svg

The SVG needs no other file and follows the reader's light or dark theme.
"""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from xml.sax.saxutils import escape

WIDTH, TOP, ROW = 1000, 96, 34  # pixels
LEFT_PANEL = (70, 400)  # x range
RIGHT_PANEL = (620, 900)
STAGES = ("project", "bin", "forward", "loss", "backward", "optimiser")

STYLE = """
  svg { font: 13px system-ui, sans-serif; --surface: #fcfcfb; --ink: #0b0b0b; --faint: #52514e; --line: #d9d8d3;
    --cpu: #2a78d6; --reference: #c8501f; --project: #2a78d6; --bin: #1baf7a; --forward: #eda100; --loss: #008300;
    --backward: #4a3aa7; --optimiser: #e34948; }
  @media (prefers-color-scheme: dark) { svg { --surface: #1a1a19; --ink: #fff; --faint: #c3c2b7; --line: #3d3c39;
    --cpu: #5b9cec; --reference: #f08a5d; --project: #3987e5; --bin: #199e70; --forward: #c98500; --loss: #008300;
    --backward: #7768df; --optimiser: #e66767; } }
  text { fill: var(--ink); } .faint { fill: var(--faint); } .title { font-size: 17px; font-weight: 600; }
  .head { font-weight: 600; } .small { font-size: 11px; } .line { stroke: var(--line); }
"""


def main() -> None:
    parser = argparse.ArgumentParser(description="Draw the figure of a benchmark of the rasterizers.")
    parser.add_argument("json", type=Path, help="what hgs bench raster --json wrote")
    parser.add_argument("svg", type=Path, help="the figure")
    options = parser.parse_args()
    options.svg.parent.mkdir(parents=True, exist_ok=True)
    options.svg.write_text(figure(json.loads(options.json.read_text())))


def figure(report: dict[str, Any]) -> str:
    """Return the SVG of a report."""
    fewest = min(point["threads"] for point in report["points"])
    bars = [p for p in report["points"] if p["threads"] == fewest and p["stages"]["project"] is not None]
    height = TOP + max(10, len(bars) + 2) * ROW + 60
    machine = report["machine"]
    about = f"{machine['cpu']}, {machine['cores']} cores, kernels {machine['instruction_set'] or 'none'}, " + (
        f"torch {machine['torch']}"
    )
    parts = [
        text(20, 32, "Rasterizers: speed against error", "title"),
        text(20, 54, f"{about}. Whole training iterations on synthetic scenes, medians.", "faint"),
        *scatter(report, height - 60),
        *stage_bars(report, bars, fewest),
    ]
    return "\n".join(
        [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" role="img">',
            "<title>Rasterizers: speed against error</title>",
            f"<style>{STYLE}</style>",
            f'<rect width="{WIDTH}" height="{height}" fill="var(--surface)"/>',
            *parts,
            "</svg>\n",
        ]
    )


def scatter(report: dict[str, Any], bottom: float) -> list[str]:
    """Milliseconds per iteration over the error of the picture, both logarithmic, for every point with an error."""
    points = [p for p in report["points"] if p["errors"] is not None and p["errors"]["image"] > 0]
    x0, x1 = LEFT_PANEL
    parts = [text(20, TOP, "Milliseconds per iteration", "head")]
    if not points:
        return [*parts, text(20, TOP + 24, "no errors were measured", "faint")]
    top = TOP + 50
    xs, ys = [p["errors"]["image"] for p in points], [1e3 * p["iteration"] for p in points]
    x_low, x_high, y_low, y_high = *decades(xs), *decades(ys)

    def place(p: dict[str, Any]) -> tuple[float, float]:
        x = (math.log10(p["errors"]["image"]) - x_low) / (x_high - x_low)
        y = (math.log10(1e3 * p["iteration"]) - y_low) / (y_high - y_low)
        return x0 + x * (x1 - x0), bottom - y * (bottom - top)

    for decade in range(x_low, x_high + 1):
        x = x0 + (decade - x_low) / (x_high - x_low) * (x1 - x0)
        parts += [line(x, top, x, bottom), text(x, bottom + 18, f"1e{decade}", "faint", "middle")]
    for decade in range(y_low, y_high + 1):
        y = bottom - (decade - y_low) / (y_high - y_low) * (bottom - top)
        parts += [line(x0, y, x1, y), text(x0 - 8, y + 4, f"{10**decade:g}", "faint", "end")]
    parts.append(text((x0 + x1) / 2, bottom + 40, "relative L2 error of the picture", "faint", "middle"))

    threads = sorted({p["threads"] for p in points})
    across = 20.0
    for backend, name in (("cpu", "cpu"), ("reference", "batched torch")):
        if any(p["backend"] == backend for p in points):
            parts += [dot(across + 6, TOP + 20, backend, True), text(across + 17, TOP + 24, name)]
            across += 37 + 7 * len(name)
    for count in threads:
        label = f"{count} thread" + ("s" if count > 1 else "")
        parts += [dot(across + 6, TOP + 20, "ink", count == threads[0]), text(across + 17, TOP + 24, label)]
        across += 37 + 7 * len(label)
    places = [place(p) for p in points]
    for p, (x, y) in zip(points, places, strict=True):
        parts.append(dot(x, y, p["backend"], p["threads"] == threads[0]))
        if p["threads"] == threads[0]:
            end = x + 18 + 7 * len(p["size"])
            crowded = end > x1 or any(x < other <= end and abs(height - y) < 12 for other, height in places)
            parts.append(text(x + (-12 if crowded else 12), y + 4, p["size"], "small", "end" if crowded else "start"))
    return parts


def stage_bars(report: dict[str, Any], bars: Sequence[dict[str, Any]], threads: int) -> list[str]:
    """The shares of the stages of the cpu backend, one bar per size, and how long they take together."""
    x0, x1 = RIGHT_PANEL
    parts = [text(x0 - 130, TOP, f"Where the cpu backend's time goes, {threads} thread" + "s" * (threads > 1), "head")]
    if not bars:
        return [*parts, text(x0 - 130, TOP + 24, "the cpu backend was not measured", "faint")]
    across = x0 - 130.0
    for stage in STAGES:
        parts += [box(across, TOP + 14, 11, 11, stage), text(across + 16, TOP + 24, stage)]
        across += 34 + 7 * len(stage)
    for row, point in enumerate(bars):
        y = TOP + 50 + row * ROW
        parts.append(text(x0 - 12, y + 16, point["size"], "", "end"))
        whole, x = sum(point["stages"].values()), float(x0)
        for stage in STAGES:
            share = point["stages"][stage] / whole
            width = share * (x1 - x0)
            parts.append(box(x, y, max(0.5, width - 2), 22, stage))
            if share >= 0.1:
                parts.append(text(x + width / 2 - 1, y + 15, f"{share:.0%}", "small", "middle", inside(stage)))
            x += width
        parts.append(text(x1 + 8, y + 16, f"{1e3 * point['iteration']:.1f} ms"))
    speedups = [s for s in report["speedups"] if s["threads"] == threads]
    if speedups:
        ratios = ", ".join(f"{s['reference_over_cpu']:.0f} at {s['size']}" for s in speedups)
        y = TOP + 50 + len(bars) * ROW + 24
        parts.append(text(x0 - 130, y, "Batched torch takes so many times as long, forward and backward:", "faint"))
        parts.append(text(x0 - 130, y + 20, ratios))
    return parts


def decades(values: Sequence[float]) -> tuple[int, int]:
    """Return the powers of ten that enclose positive values."""
    low, high = math.floor(math.log10(min(values))), math.ceil(math.log10(max(values)))
    return low, max(high, low + 1)


def text(x: float, y: float, words: str, kind: str = "", anchor: str = "start", fill: str = "") -> str:
    style = f' style="fill: {fill}"' if fill else ""
    return f'<text x="{x:.1f}" y="{y:.1f}" class="{kind}" text-anchor="{anchor}"{style}>{escape(words)}</text>'


def inside(stage: str) -> str:
    """Return the ink that can be read on a stage's colour in both themes."""
    return "#0b0b0b" if stage in ("bin", "forward") else "#fff"


def line(x0: float, y0: float, x1: float, y1: float) -> str:
    return f'<line x1="{x0:.1f}" y1="{y0:.1f}" x2="{x1:.1f}" y2="{y1:.1f}" class="line"/>'


def box(x: float, y: float, width: float, height: float, colour: str) -> str:
    return f'<rect x="{x:.1f}" y="{y:.1f}" width="{width:.1f}" height="{height}" rx="2" fill="var(--{colour})"/>'


def dot(x: float, y: float, colour: str, filled: bool) -> str:
    fill = f"var(--{colour})" if filled else "var(--surface)"
    return f'<circle cx="{x:.1f}" cy="{y:.1f}" r="5" fill="{fill}" stroke="var(--{colour})" stroke-width="2"/>'


if __name__ == "__main__":
    main()
