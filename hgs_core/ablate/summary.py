"""Means and deviations over seeds, and how far every row is from the full method."""

from __future__ import annotations

import statistics
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from hgs_core.ablate.ablation_rows import FULL

__all__ = ["ENOUGH_SEEDS", "FIGURES", "NEAR_DECIBELS", "RowSummary", "summarise"]

FIGURES = (
    "psnr",
    "psnr_dynamic",
    "ssim",
    "ssim_dynamic",
    "flicker",
    "bytes_static",
    "bytes_dynamic",
    "splats_static",
    "splats_dynamic",
    "train_seconds",
)
"""The fields of eval.json that are compared."""

NEAR_DECIBELS = 0.5  # dB: runs of published methods that differ in the seed alone differ by 0.2 to 0.3
ENOUGH_SEEDS = 3

Scores = Mapping[str, Any]
"""The fields of eval.json."""


@dataclass(frozen=True)
class RowSummary:
    """One row over its seeds; a figure that a run does not have is None."""

    name: str
    runs: Sequence[Mapping[str, Any]]  # seed and figures of each
    mean: Mapping[str, float | None]
    deviation: Mapping[str, float | None]  # sample deviation (n - 1); None for a single seed
    psnr_difference: float | None  # dB, mean over the seeds of the row minus the full method with the same seed
    needs_seeds: bool  # nearer to the full method than NEAR_DECIBELS with fewer than ENOUGH_SEEDS


def summarise(scores: Mapping[str, Mapping[int, Scores]]) -> list[RowSummary]:
    """Return a summary of each row of `scores[row][seed]`, among which is the full method."""
    return [_summary(name, by_seed, scores[FULL.name]) for name, by_seed in scores.items()]


def _summary(name: str, by_seed: Mapping[int, Scores], full: Mapping[int, Scores]) -> RowSummary:
    mean, deviation = {}, {}
    for figure in FIGURES:
        values = [float(scores[figure]) for scores in by_seed.values() if scores[figure] is not None]
        whole = len(values) == len(by_seed)
        mean[figure] = statistics.fmean(values) if whole else None
        deviation[figure] = statistics.stdev(values) if whole and len(values) > 1 else None
    pairs = [(by_seed[seed]["psnr"], full[seed]["psnr"]) for seed in by_seed if seed in full]
    both = [row - whole for row, whole in pairs if row is not None and whole is not None]
    difference = statistics.fmean(both) if both and name != FULL.name else None
    return RowSummary(
        name,
        [{"seed": seed, **{figure: scores[figure] for figure in FIGURES}} for seed, scores in by_seed.items()],
        mean,
        deviation,
        difference,
        difference is not None and abs(difference) < NEAR_DECIBELS and len(both) < ENOUGH_SEEDS,
    )
