"""The figures at the head of a report, and the request of the run."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

from hgs_core.base.config_fields import flat_fields
from hgs_core.metrics.lpips import NETWORK
from hgs_core.report.sources import FinishedRun
from hgs_core.runs.run_config import PRESETS, RunConfig

__all__ = ["Figure", "config_changes", "key_figures", "megabytes", "per_frames"]

# Scores that eval.json may have: name, label, decimals, unit.
_SCORES = (
    ("psnr", "PSNR", 2, "dB"),
    ("psnr_dynamic", "PSNR where it moves", 2, "dB"),
    ("ssim", "SSIM", 4, ""),
    ("ssim_dynamic", "SSIM where it moves", 4, ""),
    ("lpips", f"LPIPS, {NETWORK}", 4, ""),
    ("lpips_dynamic", f"LPIPS, {NETWORK}, where it moves", 4, ""),
    ("psnr_rig", "PSNR through the mean lens", 2, "dB"),
    ("psnr_dynamic_rig", "PSNR through the mean lens where it moves", 2, "dB"),
    ("ssim_rig", "SSIM through the mean lens", 4, ""),
    ("ssim_dynamic_rig", "SSIM through the mean lens where it moves", 4, ""),
    ("lpips_rig", f"LPIPS, {NETWORK}, through the mean lens", 4, ""),
    ("lpips_dynamic_rig", f"LPIPS, {NETWORK}, through the mean lens where it moves", 4, ""),
    ("psnr_colour_corrected", "PSNR, colours matched per camera", 2, "dB"),
    ("psnr_dynamic_colour_corrected", "PSNR where it moves, colours matched", 2, "dB"),
    ("psnr_lens_corrected", "PSNR, lenses and colours matched", 2, "dB"),
    ("psnr_dynamic_lens_corrected", "PSNR where it moves, lenses and colours matched", 2, "dB"),
    ("psnr_static", "PSNR where it is still", 2, "dB"),
    ("ms_ssim", "MS-SSIM", 4, ""),
    ("flip", "FLIP", 4, ""),
    ("flicker", "flicker", 4, ""),
    ("flicker_steady", "flicker of the truth itself", 4, ""),
)


@dataclass(frozen=True)
class Figure:
    """A number worth a large print."""

    key: str  # the field in eval.json, or the figure's own key
    label: str
    value: str
    unit: str = ""
    note: str = ""


def key_figures(run: FinishedRun) -> list[Figure]:
    """Return the scores that were measured, then size, splats and speed."""
    figures = []
    for key, label, decimals, unit in _SCORES:
        value = run.score(key)
        if value is not None and (run.learned_lens or not key.endswith("_rig")):
            figures.append(Figure(key, label, f"{value:.{decimals}f}", unit))
    frames = run.scores.get("frames")
    figures.append(Figure("bytes_total", "size", f"{megabytes(run.bytes_total):.3f}", "MB", "chunks and manifest"))
    if isinstance(frames, int) and frames > 1:
        for count in (50, 300):
            scaled = "" if frames == count else f"scaled from {frames} frames"
            size = megabytes(per_frames(run.bytes_total, frames, count))
            figures.append(Figure(f"mb_{count}", f"per {count} frames", f"{size:.3f}", "MB", scaled))
    totals = run.manifest.totals
    splats = f"{totals.splats_static:,} static, {totals.splats_dynamic:,} dynamic"
    figures.append(Figure("splats", "splats", f"{totals.splats_static + totals.splats_dynamic:,}", "", splats))
    figures.append(Figure("minutes", "training", f"{run.seconds / 60:.1f}", "min", f"{run.iterations:,} iterations"))
    if run.seconds > 0:
        rate = run.iterations / run.seconds
        figures.append(Figure("rate", "speed", f"{rate:.1f}", "it/s", "iterations per second"))
    return figures


def per_frames(size: float, frames: int, count: int) -> float:
    """Return a size scaled from `frames` to `count` frames."""
    return size / frames * count


def megabytes(size: float) -> float:
    """Return bytes as MB of 10^6."""
    return size / 1e6


def config_changes(config: RunConfig) -> list[tuple[str, str, str]]:
    """Return (field, the preset's value, the run's value) of all fields that differ, held-out cameras aside."""
    given = flat_fields(config.to_json())
    preset = flat_fields(RunConfig(config.preset).changed(PRESETS.get(config.preset, {})).to_json())
    return [
        (name, _words(preset[name]), _words(value))
        for name, value in given.items()
        if name != "capture.hold_out" and value != preset[name]
    ]


def _words(value: Any) -> str:
    return value if isinstance(value, str) else json.dumps(value)
