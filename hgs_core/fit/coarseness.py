"""How finely a trained scene is encoded: the coarsest settings with which the training views keep the budget."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from hgs_core.base.arrays import Floats
from hgs_core.codec.encoder.decoded_preview import quantised_scene
from hgs_core.codec.encoder.encode_settings import EncodeSettings
from hgs_core.codec.encoder.utility import Utility
from hgs_core.fit.dynamic_share import dynamic_share
from hgs_core.fit.encoding_loss import Decibels, Loss
from hgs_core.fit.encoding_views import EncodeViews
from hgs_core.fit.fine_tune import FineTune
from hgs_core.fit.fit_config import BUDGETS
from hgs_core.scene.splats import HybridScene
from hgs_core.train.checkpoint import TrainState
from hgs_core.train.train_config import TrainConfig

__all__ = ["Fitted", "fit"]

COARSENESS_ROUNDS = 5  # rounds of the search for the coarseness; most scenes need two or three
LOSS_LEFT_AFTER_TUNING = 0.5  # about the share of a loss left by fine-tuning
TUNING_ROUNDS = 3  # each with the coarseness that the loss after the one before suggests
LARGEST_TUNING_RATIO = 1.4  # factor from one to the next
BUDGET_SHARE_NEAR_ENOUGH = 0.85  # share of the budget that is near enough
COARSENESS = (0.1, 8.0)
LARGEST_COARSENESS_RATIO = 4.0  # factor between two coarsenesses tried


@dataclass(frozen=True)
class Fitted:
    """The scene to encode, and its settings."""

    scene: HybridScene[Floats]  # exact, trained further if that was asked for
    utility: Utility  # utility of its splats
    settings: EncodeSettings
    loss: Decibels  # loss on the views of the search, against the better of trained and fine-tuned scene


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
    """Find the coarsest settings that keep the budget on the training views and on their moving pixels.

    Where moving pixels would lose more than whole pictures, dynamic splats are coded less coarsely than static ones
    (`dynamic_share.py`). With `iterations` above 0 the scene is trained further as it decodes (`fine_tune.py`), and the
    loss is what remains after that; without a capture there is nothing to train with. `trained` is called with the
    iterations done.

    Raises:
        InputError: a frame or a mask cannot be read, or a splat cannot be encoded.
    """
    allowed = BUDGETS[budget]
    loss = Loss(scene, views, views.trained)
    # The loss grows about with the square of the coarseness: of the default budget, 0.1 dB is about coarseness 0.4.
    first = EncodeSettings(coarseness=0.4 * math.sqrt(allowed / 0.1))

    def coded(scene: HybridScene[Floats], utility: Utility, settings: EncodeSettings) -> HybridScene[Floats]:
        return quantised_scene(scene, views.every_camera, views.times, utility, settings).decoded

    decoded = coded(scene, utility, first)
    measured = {first: loss.of(decoded)}
    tuned = iterations >= TUNING_ROUNDS and views.capture is not None
    share = dynamic_share(scene, decoded, loss, measured[first], tuned=tuned)
    start = dataclasses.replace(first, dynamic_share=share)

    def lost(coarseness: float) -> float:
        settings = dataclasses.replace(start, coarseness=coarseness)
        if settings not in measured:
            measured[settings] = loss.of(coded(scene, utility, settings))
        return measured[settings].most

    def coarsest() -> Fitted:
        coarseness, _ = _coarsest(lost, allowed, start.coarseness)
        settings = dataclasses.replace(start, coarseness=coarseness)
        return Fitted(scene, utility, settings, measured[settings])

    if not tuned:
        return coarsest()
    coarseness = _next_coarseness(
        start.coarseness, lost(start.coarseness), allowed / LOSS_LEFT_AFTER_TUNING, LARGEST_COARSENESS_RATIO
    )
    tune = FineTune(scene, utility, views, dataclasses.replace(config, iterations=iterations), seed, states)
    best: Fitted | None = None
    # What was trained at one coarseness fits the codes of no other as well, so that every try is trained for.
    for done in range(TUNING_ROUNDS):
        begin, end = (iterations * part // TUNING_ROUNDS for part in (done, done + 1))
        settings = dataclasses.replace(start, coarseness=coarseness)
        tune.run(settings, range(begin, end), trained)
        # What training further gains is for the viewer: the codes may not spend it.
        left = loss.of(coded(tune.scene, tune.utility, settings)).without_gain(loss.of(tune.scene))
        if left.most <= allowed and (best is None or coarseness > best.settings.coarseness):
            best = Fitted(tune.scene, tune.utility, settings, left)
        aim = allowed if left.most <= allowed else BUDGET_SHARE_NEAR_ENOUGH * allowed
        coarseness = _next_coarseness(coarseness, left.most, aim, LARGEST_TUNING_RATIO)
    return best or coarsest()


def _next_coarseness(current: float, loss: float, target: float, largest_ratio: float) -> float:
    """Return the coarseness that should lose `target` dB, given that `current` loses `loss` dB.

    The two coarsenesses differ by a factor of `largest_ratio` at most.
    """
    change = math.sqrt(target / max(loss, target / largest_ratio**2))
    return _within(current * max(change, 1 / largest_ratio))


def _within(coarseness: float) -> float:
    return min(max(coarseness, COARSENESS[0]), COARSENESS[1])


def _coarsest(lost: Callable[[float], float], allowed: float, start: float) -> tuple[float, float]:
    """Return about the largest coarseness that loses no more than `allowed` dB, and its loss.

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
