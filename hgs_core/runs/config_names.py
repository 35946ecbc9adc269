"""The names of a config's fields: dotted paths by stage, and the flat names that earlier versions wrote."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from hgs_core.base.errors import InputError

__all__ = ["OLD_NAMES", "by_stage"]

OLD_NAMES: Mapping[str, str] = {
    "hold_out": "capture.hold_out",
    "downscale": "capture.downscale",
    "frame_memory_mib": "capture.frame_memory_mib",
    "static_points": "points.static",
    "dynamic_points": "points.dynamic",
    "init_interval": "points.interval",
    "cycles": "train.iterations",
    "iterations": "train.iterations",
    "stages": "train.stages",
    "motion_order": "train.motion_order",
    "segment_frames": "train.segment_frames",
    "antialiased": "train.antialiased",
    "colour_correction": "train.colour_correction",
    "dssim": "train.dssim",
    "coarse_until": "train.coarse_until",
    "settle_from": "train.settle_from",
    "settled": "train.settled",
    "steps_by_life": "train.steps_by_life",
    "checkpoint_every": "train.checkpoint_every",
    "backend": "train.backend",
    "density": "train.density.method",
    "max_static": "train.density.max_static",
    "max_dynamic": "train.density.max_dynamic",
    "densify_from": "train.density.start",
    "densify_until": "train.density.end",
    "densify_every": "train.density.every",
    "grow_gradient": "train.density.grow_gradient",
    "clone_scale": "train.density.clone_scale",
    "prune_opacity": "train.density.prune_opacity",
    "prune_contribution": "train.density.prune_contribution",
    "birth_rounds": "train.density.birth_rounds",
    "infill": "train.density.infill",
    "labels": "train.labels.initial",
    "adaptive_labels": "train.labels.adaptive",
    "still_pixels": "train.labels.still_pixels",
    "restless_error": "train.labels.restless_error",
    "learning_rates": "train.learning_rates",
    "budget": "encode.budget",
}
"""Where the fields of earlier versions' flat configs are now; `--set` and the API take these names too."""


def by_stage(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return values that stand under dotted or old names as nested mappings by stage, the plain form of a config.

    Raises:
        InputError: a field is given twice, under two names or as a part and by its path.
    """
    nested: dict[str, Any] = {}
    for name, value in values.items():
        first, *rest = name.split(".")
        *parts, last = (*OLD_NAMES.get(first, first).split("."), *rest)
        target = nested
        for part in parts:
            target = target.setdefault(part, {})
            if not isinstance(target, dict):
                raise _twice(name, (*parts, last))
        if not _merge(target, last, value):
            raise _twice(name, (*parts, last))
    return nested


def _merge(target: dict[str, Any], name: str, value: Any, depth: int = 3) -> bool:  # no config is nested deeper
    """Put a value into a mapping, or the items of a mapping into the one there; False if something is there already."""
    if depth and isinstance(value, Mapping) and isinstance(target.setdefault(name, {}), dict):
        return all(_merge(target[name], item, below, depth - 1) for item, below in value.items())
    if name in target:
        return False
    target[name] = value
    return True


def _twice(name: str, path: tuple[str, ...]) -> InputError:
    return InputError(f"config.{name[:80]}", f"config.{'.'.join(path)[:80]} is given twice", "give it once")
