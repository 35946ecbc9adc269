"""Fine-tuning: a scene is trained a little further, drawn as it decodes, to recover the loss of quantisation.

The exact numbers learn, but what is drawn is them plus the offset that quantisation gives them: held for some
iterations, in which the gradients of the decoded scene move both, then found anew (a straight-through estimator in
blocks).
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from typing import Any, TypeVar

import numpy as np
import torch
from torch import Tensor

from hgs_core.base.arrays import Floats
from hgs_core.codec.encoder.decoded_preview import Quantised, quantised_scene
from hgs_core.codec.encoder.encode_settings import EncodeSettings
from hgs_core.codec.encoder.utility import Utility
from hgs_core.fit.encoding_views import EncodeViews
from hgs_core.render.backends import training_device
from hgs_core.render.threads import one_torch_thread
from hgs_core.scene.splats import DynamicSplats, HybridScene, Segment, StaticSplats
from hgs_core.train.checkpoint import TrainState
from hgs_core.train.initial_splats import scene_extent
from hgs_core.train.rmsprop import RmsProp
from hgs_core.train.schedule import Schedule
from hgs_core.train.segment_cuts import cut_into_segments
from hgs_core.train.step import take_step
from hgs_core.train.train_config import TrainConfig
from hgs_core.train.training_views import TrainingViews

__all__ = ["FineTune"]

ITERATIONS_PER_OFFSET = 50  # iterations for which the offset is held
# As a share of the step sizes of training; falls to nothing along a cosine. More disturbs a scene whose steps have
# settled.
STEP_SIZE_SHARE = 0.05

S = TypeVar("S", StaticSplats[Floats], DynamicSplats[Floats])


class FineTune:
    """The learning scene, the utility of its splats, and the optimisers."""

    def __init__(
        self,
        scene: HybridScene[Floats],
        utility: Utility,
        views: EncodeViews,
        config: TrainConfig,
        seed: int,
        states: Sequence[TrainState],
    ) -> None:
        """Begin with a trained scene and the states in which its segments' trainings ended, if they are known.

        It will be trained for the config's iterations in all; the training cameras' colour maps stay as they are.
        RMSprop goes on from its moments: without them its first steps are as large for numbers that nothing pulls at as
        for others, and undo more than a few hundred iterations make good.
        """
        assert views.capture is not None
        self.scene, self.utility = scene, utility
        self._views = views
        # Of the step sizes those are wanted that positions have at the end of training, and others at its beginning.
        rates = dataclasses.replace(config.learning_rates, position=config.learning_rates.position_final)
        self._config = dataclasses.replace(config, stages="together", learning_rates=rates)
        self._device = training_device(config.backend)
        correction = states[0].correction if states else None
        self._correction = None if correction is None else correction.to(self._device)
        self._segments = cut_into_segments(views.capture.times, config.segment_frames)
        self._training = [
            TrainingViews(views.capture, views.trained, self._config, segment, None, seed, self._device)
            for segment in self._segments
        ]
        for learned in self._training if states else []:
            learned.time_shifts = states[0].time_shifts
        extent = scene_extent(np.array([camera.position for camera in views.trained.values()]))
        self._schedules = [Schedule(self._config, extent, segment.frames) for segment in self._segments]
        static = states[0].static_optimiser if states else RmsProp.of(scene.static.map(self._tensor))
        dynamic = [state.dynamic_optimiser for state in states] or [
            RmsProp.of(segment.dynamic.map(self._tensor)) for segment in scene.segments
        ]
        self._static: RmsProp[StaticSplats[Tensor]] = static.to(self._device)
        self._dynamic: list[RmsProp[DynamicSplats[Tensor]]] = [optimiser.to(self._device) for optimiser in dynamic]

    def run(self, settings: EncodeSettings, iterations: range, trained: Callable[[int], None]) -> None:
        """Train for some iterations with the scene coded by `settings`; dropped splats are gone.

        Step sizes fall to nothing within these iterations, whose numbers decide which views are seen. `trained` is
        called with the iterations done after each; what it raises ends the training.
        """
        blocks = -(-len(iterations) // ITERATIONS_PER_OFFSET)
        with one_torch_thread():
            for i in range(blocks):
                coded = self._coded(settings)
                drawn = coded.decoded.map(self._tensor)
                for place in range(len(iterations) * i // blocks, len(iterations) * (i + 1) // blocks):
                    share = STEP_SIZE_SHARE * 0.5 * (1 + math.cos(math.pi * place / len(iterations)))
                    self._iteration(drawn, iterations[place], share)
                    trained(iterations[place] + 1)
                self._move(coded, drawn)

    def _coded(self, settings: EncodeSettings) -> Quantised:
        """Quantise the scene; utilities and moments follow the splats that are kept."""
        coded = quantised_scene(self.scene, self._views.cameras, self._views.times, self.utility, settings)
        self._static.select(torch.from_numpy(coded.static_rows).to(self._device), 0)
        for optimiser, rows in zip(self._dynamic, coded.dynamic_rows, strict=True):
            optimiser.select(torch.from_numpy(rows).to(self._device), 0)
        self.utility = Utility(
            self.utility.static.take(coded.static_rows),
            tuple(of.take(rows) for of, rows in zip(self.utility.dynamic, coded.dynamic_rows, strict=True)),
        )
        return coded

    def _move(self, coded: Quantised, drawn: HybridScene[Tensor]) -> None:
        exact, decoded = coded.exact, coded.decoded
        self.scene = dataclasses.replace(
            exact,
            static=_moved(exact.static, decoded.static, drawn.static),
            segments=tuple(
                Segment(before.start, before.end, _moved(before.dynamic, shown.dynamic, now.dynamic))
                for before, shown, now in zip(exact.segments, decoded.segments, drawn.segments, strict=True)
            ),
        )

    def _iteration(self, drawn: HybridScene[Tensor], iteration: int, share: float) -> None:
        number, turn = iteration % len(self._segments), iteration // len(self._segments)
        view = self._training[number].of_iteration(turn, 1.0)
        dynamic, schedule = drawn.segments[number].dynamic, self._schedules[number]
        take_step(drawn.static, dynamic, view, self._config, gradients="all", correction=self._correction)
        self._static.step(drawn.static, _scaled(schedule.static_rates(0), share))
        self._dynamic[number].step(dynamic, _scaled(schedule.dynamic_rates(0, dynamic), share))

    def _tensor(self, array: Floats) -> Tensor:
        return torch.from_numpy(array.copy()).to(self._device)


def _scaled(rates: dict[str, float | Tensor], share: float) -> dict[str, float | Tensor]:
    return {name: share * rate for name, rate in rates.items()}


def _moved(exact: S, decoded: S, now: Any) -> S:
    """Apply the change made to the decoded parameters to the exact ones."""
    return type(exact)(
        *(
            (a.astype(np.float64) + (np.asarray(c.cpu()) - b.astype(np.float64))).astype(np.float32)
            for (_, a), (_, b), (_, c) in zip(exact.items(), decoded.items(), now.items(), strict=True)
        )
    )
