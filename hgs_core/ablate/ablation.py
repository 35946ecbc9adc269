"""Running an ablation: one run folder for every row and seed, of which finished ones are never repeated."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from hgs_core.ablate.ablation_rows import FULL, ROWS, Row
from hgs_core.ablate.first_points import initialise_run, moving_share
from hgs_core.ablate.plan import Ablation, RowRun
from hgs_core.ablate.summary import summarise
from hgs_core.ablate.unshared_statics import with_statics_at_rest
from hgs_core.base.atomic import write_bytes
from hgs_core.base.config_fields import flat_fields
from hgs_core.base.errors import InputError
from hgs_core.base.progress import ProgressCallback
from hgs_core.capture.open import open_capture
from hgs_core.evaluate.run import evaluate_run
from hgs_core.evaluate.truth import Truth
from hgs_core.runs.creation import create_run
from hgs_core.runs.encoding import encode
from hgs_core.runs.given_files import GivenFiles
from hgs_core.runs.stages import train
from hgs_core.scene.files import load_scene, save_scene

__all__ = ["ablate"]

_RESULT = "ablation.json"


def ablate(ablation: Ablation, progress: ProgressCallback) -> dict[str, Any]:
    """Train and score the missing runs, and return the result; ablation.json is up to date after every run.

    Everything is fixed before the first run starts: the last state of each is scored, and no score decides anything.

    Returns:
        The fields of ablation.json (docs/evaluation.md).

    Raises:
        InputError: the capture, a config, the truth or a mask is unusable, or the folder is taken; found before
            anything is written.
        StageStopped: the callback asked to stop; the same call goes on from there.
    """
    _check(ablation)
    runs = ablation.runs()
    scores: dict[str, dict[int, Mapping[str, Any]]] = {}
    moving: dict[str, float] = {}
    result: dict[str, Any] = {}
    for run in runs:
        create_run(run.path, ablation.capture, run.config, GivenFiles(ablation.masks))
        with run.folder.exclusive():
            finished = _finish(ablation, run, runs, _labelled(progress, f"{run.row.name} {run.seed}"))
        scores.setdefault(run.row.name, {})[run.seed] = finished
        kind = FULL.name if run.row.masks is None else run.row.name
        if kind not in moving:
            moving[kind] = moving_share(run)
        moving.setdefault(run.row.name, moving[kind])
        result = _result(ablation, scores, moving)
        write_bytes(ablation.out / _RESULT, json.dumps(result, indent=1, allow_nan=False).encode())
    return result


def _check(ablation: Ablation) -> None:
    """Refuse faults that would stop a later run, before the first one trains for hours."""
    config = ablation.config.capture
    if not config.hold_out:
        raise InputError("--hold-out", "names no camera to score", "give one or more")
    if not ablation.seeds or len(set(ablation.seeds)) != len(ablation.seeds):
        raise InputError("--seeds", "names no seed, or one twice", "give different whole numbers, as in 0,1,2")
    _check_folder(ablation)
    reduced: dict[str, Any] = {"downscale": config.downscale, "reductions": config.reductions}
    capture = open_capture(ablation.capture, masks=ablation.masks, **reduced)
    cameras = [capture.camera_index(name) for name in config.hold_out]
    Truth(  # reads the headers of all pictures
        capture, cameras, pictures=ablation.truth, masks=ablation.score_masks, **reduced
    )


def _check_folder(ablation: Ablation) -> None:
    out, known = ablation.out, {_RESULT, *ROWS}
    if not out.exists():
        return
    if not out.is_dir() or any(path.name not in known for path in out.iterdir()):
        raise InputError(out, "exists and is not an ablation", "choose a new or empty folder for --out")
    file = out / _RESULT
    if file.exists():
        try:
            before: dict[str, Any] = json.loads(file.read_text())
            alike = all(before[name] == value for name, value in ablation.sources().items())
        except (json.JSONDecodeError, KeyError, TypeError) as error:
            raise InputError(file, f"unreadable ({error!r})", "remove it: it is made from the runs") from error
        if not alike:
            raise InputError(out, "was made with another truth or other masks", "choose another --out")


def _finish(ablation: Ablation, run: RowRun, runs: Sequence[RowRun], progress: ProgressCallback) -> Mapping[str, Any]:
    """Bring one run to its scores, without repeating finished work, and return eval.json."""
    scores = _scores(ablation, run)
    if scores is None:
        initialise_run(run, runs, progress)
        if run.row.statics_at_rest:
            _derive(ablation.run(FULL, run.seed), run)
        train(run.path, progress)
        encode(run.path, progress)
        scores = evaluate_run(run.path, progress, truth=ablation.truth, masks=ablation.score_masks)
    return scores


def _derive(source: RowRun, run: RowRun) -> None:
    """Make the trained scene of a run from the full method's; its training time is copied from that run."""
    if not run.folder.train_summary.exists():
        save_scene(run.folder.trained, with_statics_at_rest(load_scene(source.folder.trained)))
        write_bytes(run.folder.train_summary, source.folder.train_summary.read_bytes())


def _scores(ablation: Ablation, run: RowRun) -> Mapping[str, Any] | None:
    """Return eval.json of a run, or None if there is none or somebody scored the run in another way since."""
    file: Path = run.folder.evaluation
    if not file.exists():
        return None
    scores: dict[str, Any] = json.loads(file.read_text())
    given = {"truth": ablation.truth, "masks": ablation.score_masks}
    alike = all((scores[name] == "given") == (path is not None) for name, path in given.items())
    return scores if alike and scores["cameras"] == list(ablation.config.capture.hold_out) else None


def _labelled(progress: ProgressCallback, label: str) -> ProgressCallback:
    """Say in every report which run it is about."""
    return lambda report: progress(dataclasses.replace(report, stage=f"{label} {report.stage}"))


def _result(
    ablation: Ablation, scores: Mapping[str, Mapping[int, Mapping[str, Any]]], moving: Mapping[str, float]
) -> dict[str, Any]:
    return {
        "capture": str(ablation.capture.resolve()),
        **ablation.sources(),
        "config": ablation.config.to_json(),
        "rows": [
            {
                **dataclasses.asdict(summary),
                "asks": ROWS[summary.name].asks,
                "changes": _changes(ablation, ROWS[summary.name]),
                "moving": moving[summary.name],
            }
            for summary in summarise(scores)
        ],
    }


def _changes(ablation: Ablation, row: Row) -> dict[str, Any]:
    """Return the config's fields that a row changes, by their dotted paths."""
    changed = flat_fields(row.config(ablation.config, ablation.config.seed).to_json())
    base = flat_fields(ablation.config.to_json())
    return {name: value for name, value in changed.items() if value != base[name]}
