"""Masks as picture files that people can look at and edit, in the layout that captures take (docs/captures.md)."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterable, Sequence
from itertools import count
from pathlib import Path

import numpy as np
import numpy.typing as npt
from PIL import Image

from hgs_core.base.errors import InputError
from hgs_core.base.progress import Progress, ProgressCallback

__all__ = ["export_masks", "require_new_folder"]

_STAGE = "export"


def require_new_folder(folder: Path) -> None:
    """Refuse a folder that masks cannot be written to as a whole.

    Raises:
        InputError: there is a file of this name, or the folder is not empty.
    """
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise InputError(folder, "exists and is not empty", "choose a new folder for --out")


def export_masks(
    folder: Path,
    names: Sequence[str],
    masks: Callable[[int], Iterable[npt.NDArray[np.bool_]]],
    *,
    numbers: Callable[[int], Iterable[int]] = lambda camera: count(),
    progress: ProgressCallback,
) -> None:
    """Write `folder`/<camera>/<FFFF>.png, 255 where something moves and 0 elsewhere; all of them or none.

    Args:
        folder: must be new or empty.
        names: of the cameras.
        masks: gives the masks [H, W] of all frames of a camera, by its place in `names`.
        numbers: gives what the masks of a camera are called by; from 0 unless given.
        progress: told after every camera.

    Raises:
        InputError: the folder is not empty.
        StageStopped: the callback wishes so; nothing is left behind.
    """
    require_new_folder(folder)
    folder.parent.mkdir(parents=True, exist_ok=True)
    unfinished = folder.parent / f".{folder.name}.tmp"
    shutil.rmtree(unfinished, ignore_errors=True)
    try:
        progress(Progress(_STAGE, 0, len(names)))
        for place, name in enumerate(names):
            (unfinished / name).mkdir(parents=True)
            for frame, mask in zip(numbers(place), masks(place), strict=False):  # the numbers may go on
                Image.fromarray(mask.astype(np.uint8) * 255).save(unfinished / name / f"{frame:04d}.png")
            progress(Progress(_STAGE, place + 1, len(names)))
        unfinished.replace(folder)
    except BaseException:
        shutil.rmtree(unfinished, ignore_errors=True)
        raise
