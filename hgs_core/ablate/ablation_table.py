"""An ablation's result as a table in Markdown."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from hgs_core.ablate.summary import ENOUGH_SEEDS, NEAR_DECIBELS

__all__ = ["table_text"]

_COLUMNS: Mapping[str, tuple[str, Callable[[float], str]]] = {
    "PSNR": ("psnr", lambda value: f"{value:.2f}"),
    "PSNR of what moves": ("psnr_dynamic", lambda value: f"{value:.2f}"),
    "SSIM": ("ssim", lambda value: f"{value:.4f}"),
    "SSIM of what moves": ("ssim_dynamic", lambda value: f"{value:.4f}"),
    "flicker": ("flicker", lambda value: f"{value:.4f}"),
    "MB static": ("bytes_static", lambda value: f"{value / 1e6:.3f}"),
    "MB dynamic": ("bytes_dynamic", lambda value: f"{value / 1e6:.3f}"),
    "minutes": ("train_seconds", lambda value: f"{value / 60:.1f}"),
    "static splats": ("splats_static", lambda value: f"{value:,.0f}"),
    "dynamic splats": ("splats_dynamic", lambda value: f"{value:,.0f}"),
}
"""Title, figure, and how a value is written."""


def table_text(result: Mapping[str, Any]) -> str:
    """Return the table of an ablation (the fields of ablation.json), and the meaning of its marks."""
    rows = result["rows"]
    cells = [["row", "seeds", "moving", "to full", *_COLUMNS], *(_cells(row) for row in rows)]
    lines = _aligned(cells)
    if any(row["needs_seeds"] for row in rows):
        lines += [
            "",
            f"* less than {NEAR_DECIBELS} dB from the full method: needs {ENOUGH_SEEDS} seeds to mean anything",
        ]
    return "\n".join(lines)


def _cells(row: Mapping[str, Any]) -> list[str]:
    difference = row["psnr_difference"]
    mark = "*" if row["needs_seeds"] else ""
    return [
        row["name"],
        ",".join(str(run["seed"]) for run in row["runs"]),
        f"{row['moving']:.1%}",
        "-" if difference is None else f"{difference:+.2f}{mark}",
        *(_cell(row["mean"][figure], row["deviation"][figure], text) for figure, text in _COLUMNS.values()),
    ]


def _cell(mean: float | None, deviation: float | None, text: Callable[[float], str]) -> str:
    if mean is None:
        return "-"
    return text(mean) if deviation is None else f"{text(mean)} ±{text(deviation)}"


def _aligned(rows: Sequence[Sequence[str]]) -> list[str]:
    """Return the lines of a Markdown table, names to the left and figures to the right."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = [
        [cell.rjust(w) if place else cell.ljust(w) for place, (cell, w) in enumerate(zip(row, widths, strict=True))]
        for row in rows
    ]
    rule = ["-" * (width - 1) + ":" if place else "-" * width for place, width in enumerate(widths)]
    return [f"| {' | '.join(cells)} |" for cells in (lines[0], rule, *lines[1:])]
