"""The costs of a training predicted from its size (docs/training.md, "Needs of a training").

A cost is a sum of terms, each a measured coefficient times a number that the cost grows with. `python -m
scripts.fit_training_costs` finds the coefficients in reports of `hgs bench train --json`.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from hgs_core.runs.run_config import RunConfig
from hgs_core.runs.training_need import TrainingNeed
from hgs_core.runs.training_size import SegmentSize, TrainingSize
from hgs_core.train.train_config import MOVING_FROM

__all__ = ["COSTS", "MEMORY", "course_of_training", "memory_terms", "scene_bytes", "terms", "training_need"]

COSTS: Mapping[str, tuple[float, ...]] = {
    "sync": (0.015,),
    "check": (0.39, 0.02),
    "frames": (0.012,),
    "masks": (0.021,),
    "points": (1.0, 0.33),
    "steps": (0.0041, 0.055, 0.00019),
    "moving": (0.0049, 0.023, 0.000063),
    "rounds": (1.3, 4.1),
    "encode": (14.0, 0.43, 0.09),
}
"""Seconds of processor time of each of the `terms`."""

MEMORY: Mapping[str, tuple[float, ...]] = {
    "initialise": (490.0, 1.2, 11.0),
    "train": (570.0, 1.1, 16.0, 12.0, 2.0),
    "encode": (570.0, 1.1, 16.0, 12.0, 2.0),
}
"""MiB of each of the `memory_terms`."""

_FILLED = 0.85  # share of the budgets that trained scenes have
_GROWN = 0.6  # share of the iterations after which they have it
_WATCHED = 122  # frames of each camera, at most, that are compared with the one before
_STRAIGHTENED = 0.75  # cost of straightening a picture, in multiples of decoding it
_BESIDE_DISK = 256  # MiB of pictures in memory where the others lie on disk
_PARTS = 50  # parts of the course of a training
_PUBLISH = 2.0  # seconds

_ENCODED_STATIC, _ENCODED_DYNAMIC = 10, 21  # bytes of a splat in the scenes of docs/benchmarks.md, within a fifth
_PER_STATIC, _PER_DYNAMIC, _PER_MASK = 117, 259, 7000  # bytes on disk: a checkpoint's splat, the mask of a Mpx


def training_need(size: TrainingSize, config: RunConfig) -> TrainingNeed:
    """Return the memory, disk and time of a training of this size."""
    found = {part: float(np.dot(COSTS[part], own)) for part, own in terms(size).items()}
    train = sum(found.pop(part) for part in ("steps", "moving", "rounds"))
    encode = found.pop("encode")
    found |= {"train": train, "encode": encode, "publish": _PUBLISH}
    if size.aligned:
        del found["sync"]
    if size.masked:
        del found["masks"]
    held = held_pictures(size, config)
    wanted = round(size.training_cameras * size.frames * size.pixels * 3)
    on_disk = min(wanted, config.capture.disk_bytes) if held == _BESIDE_DISK else 0
    memory = {stage: round(np.dot(MEMORY[stage], own) * 2**20) for stage, own in memory_terms(size, held).items()}
    masks = 0 if size.masked else size.training_cameras * size.frames * size.pixels / 1e6 * _PER_MASK
    splats = sum(_PER_STATIC * one.static + _PER_DYNAMIC * one.dynamic for one in size.segments)
    return TrainingNeed(memory, on_disk, round(masks + 2 * splats), found, course_of_training(size))


def scene_bytes(size: TrainingSize) -> int:
    """Return the bytes of a scene that fills its budgets of splats; segments share the static ones."""
    dynamic = sum(one.dynamic for one in size.segments)
    return _ENCODED_STATIC * size.segments[0].static + _ENCODED_DYNAMIC * dynamic


def held_pictures(size: TrainingSize, config: RunConfig) -> float:
    """Return how many MiB of decoded pictures the process holds."""
    wanted = size.training_cameras * size.frames * size.pixels * 3
    fits = wanted <= config.capture.cache_bytes * 4 / 5 or not config.capture.picture_disk_gib
    return min(wanted, config.capture.cache_bytes) / 2**20 if fits else _BESIDE_DISK


def terms(size: TrainingSize) -> dict[str, tuple[float, ...]]:
    """Return the numbers that each part's cost is a multiple of."""
    cameras, frames = size.training_cameras, size.frames
    filmed, shown = size.filmed_pixels / 1e6, size.pixels / 1e6
    decoded = filmed * (1 + _STRAIGHTENED * size.straightened)
    compared = size.cameras * min(frames, _WATCHED) * decoded
    steps = np.concatenate([_step_terms(size, one) for one in size.segments])
    moving = np.concatenate([_step_terms(size, one, moving=True) for one in size.segments])
    splats = _FILLED * sum(one.static / len(size.segments) + one.dynamic for one in size.segments)
    return {
        "sync": (compared,),
        "check": (size.cameras, compared),
        "frames": (cameras * frames * decoded,),
        "masks": (cameras * frames * shown,),
        "points": (cameras, cameras * size.moments * shown),
        "steps": tuple(steps.sum(0)),
        "moving": tuple(moving.sum(0)),
        "rounds": (cameras * len(size.segments), cameras * len(size.segments) * shown),
        "encode": (1.0, frames * shown, splats / 1000),
    }


def memory_terms(size: TrainingSize, held: float) -> dict[str, tuple[float, ...]]:
    """Return the numbers that each stage's memory is a multiple of; `held` are the MiB of pictures."""
    shown = size.training_cameras * size.pixels / 1e6  # Mpx of one moment
    filmed = shown if size.frames > 1 else 0.0  # births look at two moments at once
    splats = max(one.static + one.dynamic for one in size.segments) / 1000
    grown = 1.0, held, shown, filmed, splats
    return {"initialise": (1.0, held, shown), "train": grown, "encode": grown}


def course_of_training(size: TrainingSize) -> tuple[float, ...]:
    """Return the share of the training's time that is over after each of equal parts of its iterations."""
    per_part: list[npt.NDArray[np.float64]] = []
    rounds = float(np.dot(COSTS["rounds"], terms(size)["rounds"])) / len(size.segments)
    for one in size.segments:
        steps = _step_terms(size, one) @ np.array(COSTS["steps"])
        moving = _step_terms(size, one, moving=True) @ np.array(COSTS["moving"])
        per_part.append(steps + moving + rounds / _PARTS)
    whole = np.cumsum(np.concatenate(per_part))[len(size.segments) - 1 :: len(size.segments)]
    return tuple(round(float(share), 4) for share in whole / whole[-1])


def _step_terms(size: TrainingSize, segment: SegmentSize, *, moving: bool = False) -> npt.NDArray[np.float64]:
    """Return [parts, 3]: the steps of a segment by equal parts of its iterations, their Mpx and their ksplats."""
    share = (np.arange(_PARTS) + 0.5) / _PARTS
    steps = np.full(_PARTS, size.iterations / _PARTS)
    if moving:
        steps = steps * size.moving_steps * (share > MOVING_FROM)
    pixels = size.pixels / 1e6 * np.where(share < size.coarse_until, 0.25, 1.0)
    first, last = size.first_static + size.first_dynamic, _FILLED * (segment.static + segment.dynamic)
    splats = first + (max(first, last) - first) * np.minimum(1.0, share / _GROWN)
    return np.stack((steps, steps * pixels, steps * splats / 1000), 1)
