"""How finely a trained scene is encoded: the coarsest settings with which the training views keep the budget."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from hgs_core.base.arrays import Doubles, Floats
from hgs_core.codec.encoder.preview import quantised_scene
from hgs_core.codec.encoder.settings import EncodeSettings
from hgs_core.codec.encoder.utility import Utility
from hgs_core.fit.config import BUDGETS
from hgs_core.fit.fine_tune import FineTune
from hgs_core.fit.views import EncodeViews
from hgs_core.render.fixed_view import FixedView
from hgs_core.render.threads import one_torch_thread
from hgs_core.scene.camera import Camera
from hgs_core.scene.splats import HybridScene
from hgs_core.train.checkpoint import TrainState
from hgs_core.train.config import TrainConfig

__all__ = ["Fitted", "Loss", "fine_tune_iterations", "fit"]

LOSS_VIEWS = 12  # in which the loss is measured
COARSENESS_ROUNDS = 5  # of quantising to find the coarseness: most scenes need two or three
LOSS_LEFT_AFTER_TUNING = 0.5  # of a loss after training further, about
TUNING_ROUNDS = 3  # each with the coarseness that the loss after the one before suggests
LARGEST_TUNING_RATIO = 1.4  # factor from one to the next
FINE_TUNE_SHARE = 1 / 60  # of a training's iterations
BUDGET_SHARE_NEAR_ENOUGH = 0.85  # of the budget: what may as well be left unspent
COARSENESS = (0.1, 8.0)
LARGEST_COARSENESS_RATIO = 4.0  # factor between two coarsenesses tried
GOLDEN_RATIO = 0.618  # fractional parts of its multiples spread evenly
IMPORTED_ERROR = 1e-3  # mean squared error (30 dB) that a scene is taken to have where no picture tells


def fine_tune_iterations(config: TrainConfig) -> int:
    """Return for how many iterations a scene is trained further before it is encoded, if nobody says otherwise."""
    return round(config.iterations * FINE_TUNE_SHARE)


class Loss:
    """What quantisation costs some views: the mean loss of PSNR, dB.

    Without pictures to compare with, the scene itself is taken to be wrong by `IMPORTED_ERROR`, to which the changes
    add; it may then stand before anything, so that the loss is the larger one of those on black and on white.
    """

    def __init__(self, scene: HybridScene[Floats], views: EncodeViews, cameras: Mapping[int, Camera]) -> None:
        """Draw `scene` in views spread over `cameras` (by index) and all time; what it loses is measured against that.

        Raises:
            InputError: a frame cannot be read.
        """
        self._cameras, self._times, self._moment = cameras, views.times, views.moment
        indices = sorted(cameras)
        self._views = [
            (indices[i * len(indices) // LOSS_VIEWS], int(i * GOLDEN_RATIO % 1 * len(views.times)))
            for i in range(LOSS_VIEWS)
        ]
        self._backgrounds = (0.0, 1.0) if views.any_background else (0.0,)
        own = self._pictures(scene)
        self._reference = own if views.truth is None else [torch.stack([views.truth(*view)]) for view in self._views]
        self._least = IMPORTED_ERROR if views.truth is None else 1e-12
        self._psnr = self._decibels(own)

    def of(self, scene: HybridScene[Floats]) -> float:
        """Return by how much `scene` is worse than the one given first."""
        return float((self._psnr - self._decibels(self._pictures(scene))).max())

    def _decibels(self, pictures: Sequence[Tensor]) -> Doubles:
        """Return the mean PSNR on each background, [B]."""
        pairs = zip(pictures, self._reference, strict=True)
        errors = np.array([((picture - true) ** 2).mean(dim=(1, 2, 3)).double().numpy() for picture, true in pairs])
        return np.asarray(-10 * np.log10(errors + self._least).mean(axis=0))

    def _pictures(self, scene: HybridScene[Floats]) -> list[Tensor]:
        """Draw each view on each background: [B, 3, H, W]."""
        tensors = scene.map(torch.from_numpy)
        pictures = []
        with one_torch_thread():
            for index, frame in self._views:
                segment = tensors.segment_at(float(self._times[frame]))
                view = FixedView(tensors.static, self._cameras[index], antialiased=scene.antialiased)
                drawn = view.frame(segment.dynamic, segment.normalised(self._moment(index, frame)))
                grounds = [drawn.rgb + (1 - drawn.alpha) * value if value else drawn.rgb for value in self._backgrounds]
                pictures.append(torch.stack(grounds).clamp(0, 1))
        return pictures


@dataclass(frozen=True)
class Fitted:
    """What is to be encoded, and how."""

    scene: HybridScene[Floats]  # exact, trained further if that was asked for
    utility: Utility  # of its splats
    settings: EncodeSettings
    loss: float  # dB, of the views that it was chosen on, against the better of the scene as it was and as it is


def fit(
    scene: HybridScene[Floats],
    views: EncodeViews,
    utility: Utility,
    budget: str,
    config: TrainConfig,
    *,
    seed: int = 0,
    iterations: int = 0,
    states: Sequence[TrainState] = (),
    trained: Callable[[int], None] = lambda done: None,
) -> Fitted:
    """Find the coarsest settings with which the training views lose no more than the budget.

    With `iterations` above 0 the scene is trained further as it decodes (`fine_tune.py`), and the loss is what remains
    after that; without a capture there is nothing to train with. `trained` is called with the iterations done.

    Raises:
        InputError: a frame cannot be read, or a splat cannot be encoded.
    """
    allowed = BUDGETS[budget]
    loss = Loss(scene, views, views.trained)

    def lost(scene: HybridScene[Floats], utility: Utility, settings: EncodeSettings) -> float:
        return loss.of(quantised_scene(scene, views.every_camera, views.times, utility, settings).decoded)

    def coarsest(allowed: float, start: float) -> Fitted:
        coarseness, decibels = _coarsest(
            lambda coarseness: lost(scene, utility, EncodeSettings(coarseness=coarseness)), allowed, start
        )
        return Fitted(scene, utility, EncodeSettings(coarseness=coarseness), decibels)

    # The loss grows about with the square of the coarseness: of the default budget, 0.1 dB is about coarseness 0.4.
    start = 0.4 * math.sqrt(allowed / 0.1)
    if iterations < TUNING_ROUNDS or views.capture is None:
        return coarsest(allowed, start)
    loses = lost(scene, utility, EncodeSettings(coarseness=start))
    coarseness = _next_coarseness(start, loses, allowed / LOSS_LEFT_AFTER_TUNING, LARGEST_COARSENESS_RATIO)
    tune = FineTune(scene, utility, views, dataclasses.replace(config, iterations=iterations), seed, states)
    best: Fitted | None = None
    # What was trained at one coarseness fits the codes of no other as well, so that every try is trained for.
    for done in range(TUNING_ROUNDS):
        first, last = (iterations * part // TUNING_ROUNDS for part in (done, done + 1))
        settings = EncodeSettings(coarseness=coarseness)
        tune.run(settings, range(first, last), trained)
        # What training further gains is for the viewer: the codes may not spend it.
        decibels = lost(tune.scene, tune.utility, settings) - min(0.0, loss.of(tune.scene))
        if decibels <= allowed and (best is None or coarseness > best.settings.coarseness):
            best = Fitted(tune.scene, tune.utility, settings, decibels)
        aim = allowed if decibels <= allowed else BUDGET_SHARE_NEAR_ENOUGH * allowed
        coarseness = _next_coarseness(coarseness, decibels, aim, LARGEST_TUNING_RATIO)
    return best or coarsest(allowed, start)


def _next_coarseness(current: float, loss: float, target: float, largest_ratio: float) -> float:
    """Return the coarseness that should lose `target` dB, given that `current` loses `loss` dB.

    The two coarsenesses differ by a factor of `largest_ratio` at most.
    """
    change = math.sqrt(target / max(loss, target / largest_ratio**2))
    return _within(current * max(change, 1 / largest_ratio))


def _within(coarseness: float) -> float:
    return min(max(coarseness, COARSENESS[0]), COARSENESS[1])


def _coarsest(lost: Callable[[float], float], allowed: float, start: float) -> tuple[float, float]:
    """Return about the largest coarseness that loses no more than `allowed` dB, and what it loses.

    The finest is returned if none does. `start` is tried first.
    """
    tried: list[tuple[float, float]] = []  # ln of coarseness and of loss, the latest first
    fitting, loses = COARSENESS[0], math.nan
    coarseness = _within(start)
    for _ in range(COARSENESS_ROUNDS):
        decibels = lost(coarseness)
        tried.insert(0, (math.log(coarseness), math.log(max(decibels, 1e-3 * allowed))))
        if coarseness == COARSENESS[0] or (decibels <= allowed and coarseness >= fitting):
            fitting, loses = coarseness, decibels
        if decibels <= allowed:
            if decibels >= BUDGET_SHARE_NEAR_ENOUGH * allowed or coarseness == COARSENESS[1]:
                break
        elif coarseness == COARSENESS[0]:
            break
        goal = math.log(0.93 * allowed)
        nearest = sorted(tried, key=lambda point: abs(point[1] - goal))
        (x, y), slope = nearest[0], 2.0
        if len(nearest) > 1:
            x2, y2 = nearest[1]
            slope = min(max((y2 - y) / (x2 - x), 0.5), 6.0)
        step = min(max((goal - y) / slope, -math.log(LARGEST_COARSENESS_RATIO)), math.log(LARGEST_COARSENESS_RATIO))
        coarseness = _within(math.exp(x + step))
    return fitting, lost(fitting) if math.isnan(loses) else loses
