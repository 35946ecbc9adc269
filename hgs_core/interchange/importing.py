"""Reading a scene from a file of another format: what is there, and what was left out or limited."""

from __future__ import annotations

import dataclasses
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from hgs_core.base.arrays import Floats
from hgs_core.base.errors import InputError
from hgs_core.interchange.changes import Action, Change, nonzero
from hgs_core.interchange.file_format import ReadSplats
from hgs_core.interchange.formats import format_of
from hgs_core.interchange.ply_sequence import read_sequence
from hgs_core.scene.opacities import opacities_of
from hgs_core.scene.splats import DynamicSplats, HybridScene, Segment, StaticSplats

__all__ = ["USUAL_DURATION", "USUAL_FRAME_RATE", "Imported", "import_scene"]

USUAL_DURATION = 50 / 30  # seconds that a 4D file lasts
USUAL_FRAME_RATE = 30.0  # of a sequence of still files

LARGEST_LOGIT = 13.82  # an opacity of 1 - 1e-6
LARGEST_LOG_SCALE = 30.0
LARGEST_RGB = 8.0
LEAST_OPACITY = 1 / 255  # below it no pixel is touched
_WORDS = {
    "means": "position", "motion": "position or motion", "log_scales": "scale", "quats": "rotation",
    "rotation": "rotation or turning", "opacity_logits": "opacity", "rgb": "colour", "time_centers": "middle of life",
    "time_log_precisions": "life",
}  # fmt: skip

S = TypeVar("S", StaticSplats[NDArray[np.float32]], DynamicSplats[NDArray[np.float32]])


@dataclass(frozen=True)
class Imported:
    """What a file holds."""

    scene: HybridScene[Floats]
    splats: int  # in the file
    changes: tuple[Change, ...]  # what was left out or changed of them


def import_scene(path: Path, duration: float = USUAL_DURATION, frame_rate: float = USUAL_FRAME_RATE) -> Imported:
    """Read a file of splats; a 4D one lasts `duration` seconds, a still one no time.

    A folder is a sequence of still ones, `frame_rate` for each second.

    Splats with non-finite values are dropped, and counted.

    Raises:
        InputError: an unknown suffix, or the file is missing, damaged, or holds no splat that can be seen.
    """
    with np.errstate(all="ignore"):  # what is not finite is counted below
        found = read_sequence(path) if path.is_dir() else _read(path)
    if path.is_dir():
        duration = len(found.dynamic) / frame_rate
    changes = list(found.changes)
    sets = found.dynamic or (DynamicSplats.empty(),)
    total = len(found.static) + sum(map(len, sets))
    if total == 0:
        raise InputError(path, "holds no splats", "give a file with at least one")
    lost: Counter[str] = Counter()
    static = _finite(found.static, lost)
    sets = tuple(_finite(dynamic, lost) for dynamic in sets)
    for words, count in lost.items():
        changes.append(Change(Action.LEFT_OUT, "splats", count, total, f"{words} is no finite number"))
    changes += _limits([static, *sets])
    static, sets = _drawable(static), tuple(map(_drawable, sets))
    logits = np.concatenate([static.opacity_logits, *(dynamic.opacity_logits for dynamic in sets)])
    if not (opacities_of(logits) >= LEAST_OPACITY).any():
        told = "; ".join(map(str, nonzero(changes)))
        raise InputError(path, "holds no splat that can be seen" + (f": {told}" if told else ""), "export it again")
    equal = np.linspace(0.0, duration if found.lasts else 0.0, len(sets) + 1).tolist()
    ends = (0.0, *found.ends) if found.ends else equal
    segments = tuple(Segment(*between, dynamic) for between, dynamic in zip(pairwise(ends), sets, strict=True))
    scene = HybridScene(static, segments, antialiased=found.antialiased)
    return Imported(scene, total, nonzero(changes))


def _read(path: Path) -> ReadSplats:
    read = format_of(path, lambda one: one.read is not None).read
    assert read is not None
    return read(path)


def _limits(sets: Sequence[StaticSplats[Floats] | DynamicSplats[Floats]]) -> list[Change]:
    """Return what `_drawable` changes."""
    logits, scales, rgb = (
        np.concatenate([getattr(splats, name) for splats in sets]) for name in ("opacity_logits", "log_scales", "rgb")
    )
    return [
        Change.where(Action.LIMITED, "opacity", np.abs(logits) > LARGEST_LOGIT, "to 0.000001 to 0.999999"),
        Change.where(
            Action.LIMITED, "scale", np.abs(scales) > LARGEST_LOG_SCALE,
            f"to e^{-LARGEST_LOG_SCALE:g} to e^{LARGEST_LOG_SCALE:g}",
        ),
        Change.where(Action.LIMITED, "colour", (rgb < 0) | (rgb > LARGEST_RGB), f"to 0 to {LARGEST_RGB:g}"),
    ]  # fmt: skip


def _drawable(splats: S) -> S:
    """Give opacities of 0 and 1 a logit, and flat axes a logarithm: renderers take finite numbers alone."""
    return dataclasses.replace(
        splats,
        opacity_logits=np.clip(splats.opacity_logits, -LARGEST_LOGIT, LARGEST_LOGIT),
        log_scales=np.clip(splats.log_scales, -LARGEST_LOG_SCALE, LARGEST_LOG_SCALE),
        rgb=np.clip(splats.rgb, 0, LARGEST_RGB),
    )


def _finite(splats: S, lost: Counter[str]) -> S:
    """Return the splats that are finite; count in `lost` which attribute of the others was the first to fail.

    No thickness, and opacities of 0 and 1, count as finite.
    """
    good = np.ones(len(splats), np.bool_)
    for name, array in splats.items():
        valid = np.isfinite(array)
        if name == "log_scales":
            valid |= np.isneginf(array)
        if name == "opacity_logits":
            valid |= np.isinf(array)
        failed = good & ~valid.reshape(len(splats), -1).all(axis=1) if len(splats) else good
        if failed.any():
            lost[_WORDS[name]] += int(failed.sum())
        good &= ~failed
    return splats.take(good)
