"""The plan of an ablation: runs, each in a folder of its own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from hgs_core.ablate.ablation_rows import Row
from hgs_core.runs.run_config import RunConfig
from hgs_core.runs.run_folder import RunFolder

__all__ = ["Ablation", "RowRun"]


@dataclass(frozen=True)
class RowRun:
    """One row with one seed."""

    row: Row
    seed: int
    path: Path  # run folder
    config: RunConfig

    @cached_property
    def folder(self) -> RunFolder:
        """The run's files."""
        return RunFolder(self.path)


@dataclass(frozen=True)
class Ablation:
    """The request: every row with every seed, on one capture."""

    capture: Path
    out: Path
    config: RunConfig  # full method; its seed is replaced
    rows: Sequence[Row]  # the full method first (`rows_named`)
    seeds: Sequence[int]
    masks: Path | None = None  # training masks, instead of the capture's own
    truth: Path | None = None  # reference pictures, instead of the capture's own
    score_masks: Path | None = None  # masks of the scored regions, instead of the capture's own

    def run(self, row: Row, seed: int) -> RowRun:
        """Return the run of a row and a seed."""
        return RowRun(row, seed, self.out / row.name / f"seed-{seed}", row.config(self.config, seed))

    def runs(self) -> list[RowRun]:
        """Return all runs in the order in which they are trained: every row with one seed, then with the next."""
        return [self.run(row, seed) for seed in self.seeds for row in self.rows]

    def sources(self) -> dict[str, str | None]:
        """Return the folders, beside the capture, that determine training and scoring."""
        paths = {"masks": self.masks, "truth": self.truth, "score_masks": self.score_masks}
        return {name: None if path is None else str(path.resolve()) for name, path in paths.items()}
