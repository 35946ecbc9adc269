"""Splats that can be drawn: others are left out, numbers beyond all limits are limited, and both are told."""

from __future__ import annotations

import dataclasses
from collections import Counter
from collections.abc import Sequence
from typing import TypeVar

import numpy as np

from hgs_core.base.arrays import Floats, Mask
from hgs_core.interchange.changes import Action, Change
from hgs_core.scene.rotations import unit_quaternions
from hgs_core.scene.splat_limits import LARGEST_COLOUR, LARGEST_COORDINATE, LARGEST_LOG_SCALE
from hgs_core.scene.splats import DynamicSplats, StaticSplats

__all__ = ["drawable"]

LARGEST_LOGIT = 13.82  # an opacity of 1 - 1e-6
NO_LENGTH = 1e-12  # least length of a quaternion
UNEVEN_LENGTH = 0.05  # difference of a quaternion's length from 1; bytes are off by less
BEYOND = f"position is beyond {LARGEST_COORDINATE:g}"
ALL_ZERO = "scale, opacity, and rotation or place are all 0: rows that were never filled"
_WORDS = {
    "means": "position",
    "motion": "position or motion",
    "log_scales": "scale",
    "quats": "rotation",
    "rotation": "rotation or turning",
    "opacity_logits": "opacity",
    "rgb": "colour",
    "time_centers": "middle of life",
    "time_log_precisions": "life",
}

S = TypeVar("S", StaticSplats[Floats], DynamicSplats[Floats])


def drawable(
    static: StaticSplats[Floats], sets: Sequence[DynamicSplats[Floats]]
) -> tuple[StaticSplats[Floats], tuple[DynamicSplats[Floats], ...], list[Change]]:
    """Return the drawable splats, with drawable numbers, and the changes."""
    total = len(static) + sum(map(len, sets))
    lost: Counter[str] = Counter()
    static, sets = _filled(static, lost), tuple(_filled(dynamic, lost) for dynamic in sets)
    static, sets = _finite(static, lost), tuple(_finite(dynamic, lost) for dynamic in sets)
    changes = [Change(Action.LEFT_OUT, "splats", count, total, reason) for reason, count in lost.items()]
    changes += [*_limits([static, *sets]), *_lengths([static, *sets])]
    return _limited(static), tuple(map(_limited, sets)), changes


def _filled(splats: S, lost: Counter[str]) -> S:
    """Leave out padding read as splats: a scale of 1, half an opacity, no rotation or no place."""
    if not len(splats):
        return splats
    places, turns = (
        (splats.means, splats.quats) if isinstance(splats, StaticSplats) else (splats.motion, splats.rotation)
    )
    filled = ~_zero(splats.log_scales) | ~_zero(splats.opacity_logits) | (~_zero(turns) & ~_zero(places))
    if not filled.all():
        lost[ALL_ZERO] += int((~filled).sum())
    return splats.take(filled)


def _zero(numbers: Floats) -> Mask:
    """Return the splats with `numbers` [N, ...] of 0 alone."""
    return np.asarray((numbers.reshape(len(numbers), -1) == 0).all(axis=1))


def _finite(splats: S, lost: Counter[str]) -> S:
    """Return the splats that are finite; count in `lost` which attribute of the others was the first to fail.

    No thickness, and opacities of 0 and 1, count as finite.
    """
    good = np.ones(len(splats), np.bool_)

    def left(failed: Mask, reason: str) -> None:
        nonlocal good
        failed &= good
        if failed.any():
            lost[reason] += int(failed.sum())
        good &= ~failed

    for name, array in splats.items():
        valid = np.isfinite(array)
        if name == "log_scales":
            valid |= np.isneginf(array)
        if name == "opacity_logits":
            valid |= np.isinf(array)
        numbers = valid.reshape(len(splats), -1) if len(splats) else np.ones((0, 1), np.bool_)
        left(np.asarray(~numbers.all(axis=1)), f"{_WORDS[name]} is no finite number")
    places = splats.means if isinstance(splats, StaticSplats) else splats.motion
    size = np.abs(places.astype(np.float64)).reshape(len(splats), -1).max(axis=1) if len(splats) else np.zeros(0)
    left(np.asarray(size > LARGEST_COORDINATE), BEYOND)
    return splats.take(good)


def _limits(sets: Sequence[StaticSplats[Floats] | DynamicSplats[Floats]]) -> list[Change]:
    """Return the changes of `_limited` to opacities, scales and colours."""
    logits, scales, rgb = (
        np.concatenate([getattr(splats, name) for splats in sets]) for name in ("opacity_logits", "log_scales", "rgb")
    )
    return [
        Change.where(Action.LIMITED, "opacity", np.abs(logits) > LARGEST_LOGIT, "to 0.000001 to 0.999999"),
        Change.where(
            Action.LIMITED,
            "scale",
            np.abs(scales) > LARGEST_LOG_SCALE,
            f"to e^{-LARGEST_LOG_SCALE:g} to e^{LARGEST_LOG_SCALE:g}",
        ),
        Change.where(Action.LIMITED, "colour", (rgb < 0) | (rgb > LARGEST_COLOUR), f"to 0 to {LARGEST_COLOUR:g}"),
    ]


def _lengths(sets: Sequence[StaticSplats[Floats] | DynamicSplats[Floats]]) -> list[Change]:
    """Return the changes of `_limited` to rotations."""
    none, uneven = (np.concatenate(parts) for parts in zip(*map(_odd_lengths, sets), strict=True))
    return [
        Change.where(Action.REPLACED, "rotation", none, "by none at all: the quaternion has no length"),
        Change.where(Action.REPLACED, "rotation", uneven, "by one of length 1: its direction alone counts"),
    ]


def _odd_lengths(splats: StaticSplats[Floats] | DynamicSplats[Floats]) -> tuple[Mask, Mask]:
    """Return the rotations without length [N], and those of another length than 1; turning ones in mid-life."""
    if isinstance(splats, DynamicSplats):
        turning = np.abs(splats.rotation[:, 1].astype(np.float64)).max(axis=1, initial=0.0) >= NO_LENGTH
        length = np.linalg.norm(splats.rotation[:, 0].astype(np.float64), axis=1)
    else:
        turning = np.zeros(len(splats), np.bool_)
        length = np.linalg.norm(splats.quats.astype(np.float64), axis=1)
    short = length < NO_LENGTH
    return short & ~turning, ~short & (np.abs(length - 1) > UNEVEN_LENGTH)


def _limited(splats: S) -> S:
    """Give opacities of 0 and 1 a logit, and flat axes a logarithm: renderers take finite numbers alone."""
    none, uneven = _odd_lengths(splats)
    turns: dict[str, Floats] = {}
    if isinstance(splats, DynamicSplats):
        length = np.linalg.norm(splats.rotation[:, 0].astype(np.float64), axis=1)[:, None, None]
        even = (splats.rotation / np.where(uneven[:, None, None], length, 1.0)).astype(np.float32)
        still = np.zeros((2, 4), np.float32)
        still[0, 0] = 1.0
        turns["rotation"] = np.where(none[:, None, None], still, even)
    else:
        units = unit_quaternions(splats.quats).astype(np.float32)
        turns["quats"] = np.where((none | uneven)[:, None], units, splats.quats)
    return dataclasses.replace(
        splats,
        opacity_logits=np.clip(splats.opacity_logits, -LARGEST_LOGIT, LARGEST_LOGIT),
        log_scales=np.clip(splats.log_scales, -LARGEST_LOG_SCALE, LARGEST_LOG_SCALE),
        rgb=np.clip(splats.rgb, 0, LARGEST_COLOUR),
        **turns,
    )
