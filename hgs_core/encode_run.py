"""How finely a trained scene is encoded: what every splat does to the training views, and the budget in decibels."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from hgs_core.camera import Camera
from hgs_core.capture.capture import Capture
from hgs_core.codec.settings import EncodeSettings
from hgs_core.codec.weights import Utility
from hgs_core.render.contribution import contributions
from hgs_core.render.fixed_view import FixedView
from hgs_core.render.threads import one_torch_thread
from hgs_core.scene.splats import HybridScene
from hgs_core.train.config import BUDGETS
from hgs_core.train.targets import target_picture

__all__ = ["fitting_settings", "measure_utility"]

CAMERAS_PER_FRAME = 4  # that every frame's splats are weighed in; the next frame takes the next cameras
VIEWS = 12  # in which the loss is measured
ROUNDS = 4  # of encoding to find the coarseness: most scenes need two
NEAR_ENOUGH = 0.85  # of the budget: what may as well be left unspent
COARSENESS = (0.25, 8.0)
FARTHEST = 4.0  # factor between two coarsenesses tried
GOLDEN = 0.618  # fractional parts of its multiples spread evenly

Floats = NDArray[np.float32]
Doubles = NDArray[np.float64]
Views = Sequence[tuple[int, int]]  # camera, frame


def measure_utility(
    scene: HybridScene[Floats], cameras: Sequence[Camera], times: Doubles, *, antialiased: bool
) -> Utility:
    """Weigh every splat in every frame, from some of `cameras` in turn; `times` [F] are the frames' seconds.

    The sum of squares of a splat's weights in a view is taken to be half its total times its peak, as it is for a
    Gaussian of which everything before it lets through the same share.
    """
    tensors = scene.map(torch.from_numpy)
    static = np.zeros(len(scene.static))
    dynamic = [np.zeros(len(segment.dynamic)) for segment in scene.segments]
    count = min(CAMERAS_PER_FRAME, len(cameras))
    step = max(1, len(cameras) // count)
    with one_torch_thread():
        for frame, seconds in enumerate(times):
            segment = tensors.segment_at(float(seconds))
            number = next(i for i, other in enumerate(tensors.segments) if other is segment)
            for i in range(count):
                camera = cameras[(frame + i * step) % len(cameras)]
                seen = contributions(
                    tensors.static, segment.dynamic, camera, segment.normalised(float(seconds)), antialiased=antialiased
                )
                squares = seen.total.astype(np.float64) * seen.peak / 2
                static += squares[: len(static)]
                dynamic[number] += squares[len(static) :]
    views = count * len(times)
    return Utility(static / views, tuple(squares / views for squares in dynamic))


def fitting_settings(
    scene: HybridScene[Floats],
    encoded: Callable[[EncodeSettings], HybridScene[Floats]],
    capture: Capture,
    cameras: Mapping[int, Camera],
    budget: str,
    *,
    antialiased: bool,
) -> EncodeSettings:
    """Return the coarsest settings with which the training views lose no more than the budget.

    `encoded` encodes the scene and decodes it again; `cameras` are those trained on, by their index in the capture.
    """
    allowed = BUDGETS[budget]
    indices = sorted(cameras)
    views = [(indices[i * len(indices) // VIEWS], int(i * GOLDEN % 1 * len(capture.times))) for i in range(VIEWS)]
    truth = {view: target_picture(capture, view[0], view[1], cameras[view[0]]) for view in views}

    def psnr(of: HybridScene[Floats]) -> float:
        pictures = _pictures(of.map(torch.from_numpy), cameras, capture.times, views, antialiased)
        errors = [float(((picture - truth[view]) ** 2).mean()) for view, picture in pictures.items()]
        return float(np.mean([-10 * math.log10(max(error, 1e-12)) for error in errors]))

    quick = EncodeSettings(compression_level=1)
    best = psnr(scene)
    # The loss grows about with the square of the coarseness: of the default budget, 0.1 dB is about coarseness 1.
    fitting, tried = COARSENESS[0], math.sqrt(allowed / 0.1)
    for _ in range(ROUNDS):
        loss = best - psnr(encoded(dataclasses.replace(quick, coarseness=tried)))
        if loss <= allowed:
            fitting = max(fitting, tried)
            if loss >= NEAR_ENOUGH * allowed or tried == COARSENESS[1]:
                break
        step = math.sqrt(0.93 * allowed / max(loss, 1e-9))
        tried = min(max(tried * min(max(step, 1 / FARTHEST), FARTHEST), COARSENESS[0]), COARSENESS[1])
    return EncodeSettings(coarseness=fitting)


def _pictures(
    scene: HybridScene[Tensor], cameras: Mapping[int, Camera], times: Doubles, views: Views, antialiased: bool
) -> dict[tuple[int, int], Tensor]:
    pictures: dict[tuple[int, int], Any] = {}
    with one_torch_thread():
        for index, frame in views:
            seconds = float(times[frame])
            segment = scene.segment_at(seconds)
            view = FixedView(scene.static, cameras[index], antialiased=antialiased)
            pictures[index, frame] = view.frame(segment.dynamic, segment.normalised(seconds)).rgb.clamp(0, 1)
    return pictures
