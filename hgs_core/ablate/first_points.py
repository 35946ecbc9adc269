"""Masks and first points of the runs of an ablation: found once, shared by all runs that start from the same."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from hgs_core.ablate.mask_changes import Mask
from hgs_core.ablate.plan import RowRun
from hgs_core.base.atomic import write_bytes
from hgs_core.base.progress import Progress, ProgressCallback
from hgs_core.runs.stages import initialise
from hgs_core.runs.training_inputs import masks_of_run, segment_starts

__all__ = ["initialise_run", "moving_share"]

_REPORT_EVERY = 20  # pictures


def initialise_run(run: RowRun, others: Sequence[RowRun], progress: ProgressCallback) -> None:
    """Give a run its masks and first points: those of another run that starts from the same, else new ones.

    Args:
        run: the run; its row's change is done to the masks.
        others: all runs of the ablation; the masks of the first one are unchanged, and there when another row's are
            changed.
        progress: called with what has been computed.

    Raises:
        InputError: a picture or a mask is missing or unreadable.
        StageStopped: the callback wishes so.
    """
    folder = run.folder
    if folder.near_planes.exists():
        return
    checked = next((other for other in others if other.folder.check.exists()), None)
    if checked is not None and not folder.check.exists():  # all runs are of one capture
        _share(checked.folder.check, folder.check)
    for other in others:
        if _points_of(other) == _points_of(run) and other.folder.near_planes.exists():
            _share_all(other.folder.masks, folder.masks)
            _share_all(other.folder.points, folder.points)
            return
    for other in others:
        if _masks_of(other) == _masks_of(run) and other.folder.masks.is_dir():
            _share_all(other.folder.masks, folder.masks)
            break
    if run.row.masks is not None and not folder.masks.exists():
        capture = folder.read_spec().open_capture()
        masks = masks_of_run(others[0].folder, capture, others[0].config)
        pictures = len(masks.cameras) * len(capture.times)
        whole = folder.masks.with_name(".masks")  # files that are missing later would be made anew, unchanged
        masks.changed(_change(run, pictures, progress)).save(whole, segment_starts(capture, run.config))
        whole.rename(folder.masks)
    initialise(run.path, progress)


def moving_share(run: RowRun) -> float:
    """Return the share of the training pictures, 0..1, that the masks of an initialised run call moving."""
    spec = run.folder.read_spec()
    return masks_of_run(run.folder, spec.open_capture(), spec.config).share()


def _masks_of(run: RowRun) -> tuple[Any, ...]:
    """Return the settings that determine a run's masks."""
    changed = () if run.row.masks is None else (run.row.name, run.seed if run.row.masks_vary else None)
    return (*changed, run.config.train.segment_frames)


def _points_of(run: RowRun) -> tuple[Any, ...]:
    """Return the settings that determine a run's first points."""
    return (_masks_of(run), run.config.seed, run.config.capture, run.config.points)


def _change(run: RowRun, pictures: int, progress: ProgressCallback) -> Callable[[int, int, Mask], Mask]:
    """Return the row's change as a function of camera, frame and mask that reports how far it is."""
    done = 0

    def change(camera: int, frame: int, mask: Mask) -> Mask:
        nonlocal done
        assert run.row.masks is not None
        changed = run.row.masks(mask, np.random.default_rng((run.seed, camera, frame)))
        done += 1
        if done % _REPORT_EVERY == 0 or done == pictures:
            progress(Progress("masks", done, pictures))
        return changed

    return change


def _share_all(source: Path, target: Path) -> None:
    target.mkdir(exist_ok=True)
    for file in sorted(source.iterdir(), key=lambda file: (file.suffix == ".json", file.name)):  # near.json comes last
        _share(file, target / file.name)


def _share(source: Path, target: Path) -> None:
    """Give a file a second name, or copy it where the file system has no hard links; no stage ever writes into it."""
    if target.exists():
        return
    try:
        target.hardlink_to(source)
    except OSError:
        write_bytes(target, source.read_bytes())
