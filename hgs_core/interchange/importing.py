"""Reading a scene from a file of another format: what is there, and what was left out or limited."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from hgs_core.base.arrays import Floats
from hgs_core.base.errors import InputError
from hgs_core.interchange.changes import Action, Change, nonzero
from hgs_core.interchange.formats import format_of
from hgs_core.scene.opacities import opacities_of
from hgs_core.scene.splats import DynamicSplats, HybridScene, Segment, StaticSplats

__all__ = ["Imported", "import_scene"]

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


def import_scene(path: Path, duration: float) -> Imported:
    """Read a file of splats; a 4D one lasts `duration` seconds, a still one no time.

    Splats with non-finite values are dropped, and counted.

    Raises:
        InputError: an unknown suffix, or the file is missing, damaged, or holds no splat that can be seen.
    """
    read = format_of(path, lambda one: one.read is not None).read
    assert read is not None
    found = read(path)
    static, dynamic, changes = found.static, found.dynamic, list(found.changes)
    total = len(static) + len(dynamic)
    if total == 0:
        raise InputError(path, "holds no splats", "give a file with at least one")
    static, lost = _finite(static)
    dynamic, lost_moving = _finite(dynamic)
    for words in dict.fromkeys((*lost, *lost_moving)):
        count = lost.get(words, 0) + lost_moving.get(words, 0)
        changes.append(Change(Action.LEFT_OUT, "splats", count, total, f"{words} is no finite number"))
    changes += _limits(static, dynamic)
    static, dynamic = _drawable(static), _drawable(dynamic)
    if not any((opacities_of(splats.opacity_logits) >= LEAST_OPACITY).any() for splats in (static, dynamic)):
        told = "; ".join(map(str, nonzero(changes)))
        raise InputError(path, "holds no splat that can be seen" + (f": {told}" if told else ""), "export it again")
    segment = Segment(0.0, duration if found.lasts else 0.0, dynamic)
    scene = HybridScene(static, (segment,), antialiased=found.antialiased)
    return Imported(scene, total, nonzero(changes))


def _limits(static: StaticSplats[Floats], dynamic: DynamicSplats[Floats]) -> list[Change]:
    """Return what `_drawable` changes."""
    logits, scales, rgb = (
        np.concatenate([getattr(static, name), getattr(dynamic, name)])
        for name in ("opacity_logits", "log_scales", "rgb")
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


def _finite(splats: S) -> tuple[S, dict[str, int]]:
    """Return the splats that are finite, and how many of the others each attribute was the first to fail.

    No thickness, and opacities of 0 and 1, count as finite.
    """
    good = np.ones(len(splats), np.bool_)
    lost: dict[str, int] = {}
    for name, array in splats.items():
        valid = np.isfinite(array)
        if name == "log_scales":
            valid |= np.isneginf(array)
        if name == "opacity_logits":
            valid |= np.isinf(array)
        failed = good & ~valid.reshape(len(splats), -1).all(axis=1) if len(splats) else good
        if failed.any():
            lost[_WORDS[name]] = int(failed.sum())
        good &= ~failed
    return splats.take(good), lost
