"""The sources of a report: the files of a run, checked."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hgs_core.base.errors import InputError
from hgs_core.base.progress import ProgressCallback
from hgs_core.codec import Manifest, load_manifest
from hgs_core.evaluate.run import evaluate_run
from hgs_core.runs.run_folder import RunFolder, RunSpec

__all__ = ["FinishedRun", "History", "finite_number", "read_run"]


@dataclass(frozen=True)
class History:
    """The reports of the first segment's training; lists of equal length, NaN for an unknown figure."""

    iteration: Sequence[float]
    seconds: Sequence[float]
    figures: Mapping[str, Sequence[float]]  # loss, psnr, static, dynamic: those that were recorded


@dataclass(frozen=True)
class FinishedRun:
    """A run with an encoded scene."""

    name: str  # the folder's
    folder: RunFolder
    spec: RunSpec
    manifest: Manifest
    seconds: float  # seconds of training
    iterations: int  # iterations of all segments
    history: History | None
    profile: Mapping[str, float]  # seconds by activity, empty if not recorded
    machine: Mapping[str, Any]  # the training's machine, empty if not recorded
    scores: Mapping[str, Any]  # eval.json, empty if it could not be made
    unscored: str  # why there are no scores

    @property
    def bytes_total(self) -> int:
        """Return the bytes of chunks, those of sound too, and manifest, as eval.json counts them."""
        manifest = self.manifest
        chunks = manifest.totals.bytes_static + manifest.totals.bytes_dynamic + manifest.bytes_audio
        return chunks + self.folder.manifest.stat().st_size

    @property
    def seen(self) -> set[str]:
        """Return the names of the scored cameras that training saw too."""
        names = self.scores.get("cameras_trained_on")
        return set(map(str, names)) if isinstance(names, list) else set()

    @property
    def learned_lens(self) -> bool:
        """Return whether the scores know a lens falloff of the training cameras."""
        return self.scores.get("lens_falloff") is not None

    def score(self, name: str) -> float | None:
        """Return a figure of eval.json, None if it is absent, null or not finite."""
        return finite_number(self.scores.get(name))

    def per_frame(self, metric: str) -> dict[str, list[float]]:
        """Return a metric of every frame by scored camera; NaN for anything but a finite number."""
        cameras = self.scores.get("per_frame")
        if not isinstance(cameras, dict):
            return {}
        series = {name: figures.get(metric) for name, figures in cameras.items() if isinstance(figures, dict)}
        return {name: _floats(values) for name, values in series.items() if isinstance(values, list) and values}


def read_run(path: Path, progress: ProgressCallback) -> FinishedRun:
    """Read a finished run; measures it first if it has no eval.json and its capture is still there.

    Raises:
        InputError: not a run, not finished, or a file of it is damaged.
    """
    folder = RunFolder(path)
    spec = folder.read_spec()
    if not folder.train_summary.exists() or not folder.manifest.exists():
        raise InputError(path, "the run has no encoded scene yet", "finish it with hgs train")
    manifest = load_manifest(folder.manifest)
    summary = _object(folder.train_summary, "train it again")
    scores, unscored = _scores(folder, progress)
    seconds, iterations = finite_number(summary.get("seconds")), finite_number(summary.get("iterations"))
    if seconds is None or iterations is None:
        raise InputError(folder.train_summary, "lacks the seconds or the iterations of training", "train the run again")
    profile, machine = summary.get("profile"), summary.get("machine")
    stages = {str(name): finite_number(value) for name, value in profile.items()} if isinstance(profile, dict) else {}
    return FinishedRun(
        name=path.resolve().name,
        folder=folder,
        spec=spec,
        manifest=manifest,
        seconds=seconds,
        iterations=int(iterations),
        history=_history(summary.get("history")),
        profile={name: value for name, value in stages.items() if value is not None and value > 0},
        machine=machine if isinstance(machine, dict) else {},
        scores=scores,
        unscored=unscored,
    )


def finite_number(value: Any) -> float | None:
    """Return `value` as a float if it is a finite number, else None."""
    number = isinstance(value, int | float) and not isinstance(value, bool)
    return float(value) if number and math.isfinite(value) else None


def _scores(folder: RunFolder, progress: ProgressCallback) -> tuple[Mapping[str, Any], str]:
    if folder.evaluation.exists():
        return _object(folder.evaluation, "delete it: it is measured again"), ""
    try:
        return evaluate_run(folder.path, progress), ""
    except InputError as error:
        return {}, f"{error.where}: {error.problem}"


def _history(value: Any) -> History | None:
    """Read the history leniently: figures of another length than `iteration` are left out."""
    if not isinstance(value, dict):
        return None
    lists = {name: _floats(figures) for name, figures in value.items() if isinstance(figures, list)}
    iteration = lists.pop("iteration", [])
    same = {name: figures for name, figures in lists.items() if len(figures) == len(iteration)}
    seconds = same.pop("seconds", [math.nan] * len(iteration))
    return History(iteration, seconds, same) if len(iteration) > 1 and same else None


def _floats(values: list[Any]) -> list[float]:
    numbers = [finite_number(value) for value in values]
    return [math.nan if number is None else number for number in numbers]


def _object(file: Path, cure: str) -> dict[str, Any]:
    try:
        value: Any = json.loads(file.read_text())
    except (OSError, ValueError) as error:
        raise InputError(file, f"unreadable ({error})", cure) from error
    if not isinstance(value, dict):
        raise InputError(file, "is not a JSON object", cure)
    return value
