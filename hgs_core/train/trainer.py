"""The trainer of a segment: every iteration, both sets learn from the composite of one view, at once or in turn."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, nullcontext
from pathlib import Path

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor

from hgs_core.base.heap import return_free_memory
from hgs_core.base.progress import Progress, ProgressCallback, StageStopped, interruptible
from hgs_core.capture.capture import Capture
from hgs_core.decompose.masks import MotionMasks
from hgs_core.metrics.psnr import decibels
from hgs_core.points.backdrop import Backdrop
from hgs_core.render.backends import training_device
from hgs_core.render.threads import one_torch_thread
from hgs_core.render.tiles import tiles_of_dynamic
from hgs_core.render.types import Gradients, ScreenStatistics
from hgs_core.scene.camera import Camera
from hgs_core.scene.splats import DynamicSplats, HybridScene, Segment, StaticSplats
from hgs_core.train.checkpoint import TrainState, fresh_state, load_state, save_state
from hgs_core.train.control import RoundContext, rounds
from hgs_core.train.initial_splats import scene_extent
from hgs_core.train.schedule import Schedule
from hgs_core.train.segment_cuts import CaptureSegment
from hgs_core.train.splats_alive import living_rows, rows_taken
from hgs_core.train.step import take_step
from hgs_core.train.train_config import TrainConfig
from hgs_core.train.training_views import TrainingView, TrainingViews

__all__ = ["Trainer"]

_HOST = torch.device("cpu")
_REPORT_EVERY = 10  # iterations
_LONGEST_SILENCE = 1.0  # seconds between two reports, each of which may stop the training
_LONGEST_APART = 6.0  # most elongation where no second camera sees the length of a needle
_SHORTEST_LIFE = 0.5  # frames at which the opacity of the briefest splat has halved


class Trainer:
    """Trains one segment of a capture.

    Args:
        capture: the whole capture; other cameras than those to train with are never read.
        cameras: those to train with by their index in the capture, with their near planes.
        config: how to train.
        seed: of everything that is drawn at random.
        segment: the frames to train on.
        start: first splats, ignored when `checkpoint` exists.
        checkpoint: where the state is kept.
        backdrop: the surface that statics lie on where cameras stand far apart; None: they lie anywhere.
        masks: what moves; without them no splats are born, and stages cannot be `separate`.
        after: the state of a finished segment whose statics, colour maps and clocks are taken over as they are; None:
            this segment trains them.
    """

    def __init__(
        self,
        capture: Capture,
        cameras: Mapping[int, Camera],
        config: TrainConfig,
        seed: int,
        segment: CaptureSegment,
        start: tuple[StaticSplats[Tensor], DynamicSplats[Tensor]],
        checkpoint: Path,
        *,
        masks: MotionMasks | None = None,
        backdrop: Backdrop | None = None,
        after: TrainState | None = None,
    ) -> None:
        self.config, self.seed, self.checkpoint, self.segment = config, seed, checkpoint, segment
        self.statics_learn = after is None
        self.device = training_device(config.backend)
        self.views = TrainingViews(capture, cameras, config, segment, masks, seed, self.device)
        extent = scene_extent(np.array([camera.position for camera in self.views.cameras]))
        self.schedule = Schedule(config, extent, segment.frames, segment.seconds)
        self.backdrop = backdrop if masks is not None else None
        self.rounds = rounds(config, masked=self.views.masked, statics_learn=self.statics_learn, backdrop=self.backdrop)
        if after is not None:
            start = (after.static, start[1])
        self.first_counts = (len(start[0]), len(start[1]))
        self.state = (
            load_state(checkpoint) if checkpoint.exists() else fresh_state(*start, len(self.views.cameras), config)
        )
        if after is not None:
            self.state.correction, self.state.time_shifts = after.correction, after.time_shifts
        if self.backdrop is not None:  # silhouettes from so few sides move with their clocks
            self.state.time_shifts = None
        self.views.time_shifts = self.state.time_shifts
        self._told = 0.0  # time of the last report, seconds
        self._torn = False  # true while a long round changes the state; the last checkpoint counts then
        self._constrain()  # colours far out of range would leave moments that stop the optimiser for long

    def run(self, progress: ProgressCallback) -> HybridScene[npt.NDArray[np.float32]]:
        """Train to the end of the schedule and return the scene.

        Raises:
            StageStopped: the callback asked to stop, or a long round was interrupted; the state was saved first.
        """
        self._told = started = time.monotonic()
        before, begun, state = self.state.seconds, self.state.iteration, self.state
        try:
            with one_torch_thread(), self._on(self.device):
                while state.iteration < self.config.iterations:
                    with state.history.timed("frames"):
                        self.views.hold(state.iteration, lambda _: self._report(progress))
                    self._iteration(state.iteration)
                    state.iteration += 1
                    self._average()
                    state.seconds = before + time.monotonic() - started
                    if state.iteration % self.config.checkpoint_every == 0:
                        save_state(self.checkpoint, state)
                    due = state.iteration % _REPORT_EVERY == 0 or state.iteration == self.config.iterations
                    if due:
                        state.history.report(state.iteration, state.seconds, len(state.static), len(state.dynamic))
                    self._report(progress, due=due)
        except StageStopped:
            if not self._torn:
                save_state(self.checkpoint, state)
            raise
        if state.iteration > begun:
            save_state(self.checkpoint, state)
        return self.scene()

    def _report(self, progress: ProgressCallback, *, due: bool = False) -> None:
        """Report the iteration where that is due, or the silence was long."""
        if due or time.monotonic() - self._told > _LONGEST_SILENCE:
            self._told = time.monotonic()
            progress(Progress("train", self.state.iteration, self.config.iterations, self.state.figures()))

    @contextmanager
    def _on(self, device: torch.device) -> Iterator[None]:
        """Keep the state on a device; steps run where the backend does, rounds of control on the host."""
        before = self.state.static.rgb.device
        self.state.to(device)
        try:
            yield
        finally:
            self.state.to(before)

    def scene(self) -> HybridScene[npt.NDArray[np.float32]]:
        """Return a copy of the splats as they are now."""
        static, dynamic = self.state.static.map(_copied), self.state.dynamic.map(_copied)
        segment = Segment(self.segment.clock.start, self.segment.clock.end, dynamic)
        return HybridScene(static, (segment,), antialiased=self.config.antialiased)

    def _iteration(self, iteration: int) -> None:
        state, config, timed = self.state, self.config, self.state.history.timed
        due = [control for control in self.rounds if control.due(iteration)]
        saved = any(control.is_long for control in due)
        if saved:  # whoever stops the training in such a round goes on with the whole iteration
            save_state(self.checkpoint, state)
        with timed("frames"):
            apart = config.stages == "separate" or self.backdrop is not None
            view = self.views.of_iteration(iteration, self.schedule.resolution(iteration), masked=apart)
        if self.backdrop is not None:  # the dynamics take theirs in a round
            if self.statics_learn:
                self._learn("static", iteration, view, ignored=view.moving)
        elif config.stages == "together" and self.statics_learn:
            self._learn("all", iteration, view)
        else:
            if len(state.static) and self.statics_learn:
                self._learn("static", iteration, view, ignored=view.moving)
            with timed("tiles"):
                tiles = tiles_of_dynamic(
                    state.dynamic, view.camera, view.moment, backend=config.backend, antialiased=config.antialiased
                )
            if tiles.any():
                still = None if view.moving is None else ~view.moving
                self._learn("dynamic", iteration, view, tiles=tiles, ignored=still)
        self._constrain()
        context = RoundContext(
            iteration,
            self.seed,
            self.schedule,
            self.views,
            self.segment,
            view.camera,
            self.first_counts,
            self.statics_learn,
        )
        self._torn = saved
        for control in due:
            with (
                timed(control.name),
                self._on(_HOST if control.on_host else self.device),
                interruptible() if saved else nullcontext(),
            ):
                control.apply(state, context)
            if control.is_long:
                return_free_memory()  # a round's pictures of all cameras leave holes that steps do not fill
        self._torn = False

    def _average(self) -> None:
        """Let the means follow; after the last iteration the splats become them, before anyone else sees them."""
        state = self.state
        if self.schedule.is_averaged(state.iteration):
            state.follow_means(statics=self.statics_learn)
            if state.iteration == self.config.iterations:
                state.become_means()
                self._constrain()  # the limits of reading a checkpoint: a mean of needles can be a longer one

    def _learn(
        self,
        stage: Gradients,
        iteration: int,
        view: TrainingView,
        *,
        tiles: npt.NDArray[np.bool_] | None = None,
        ignored: Tensor | None = None,
    ) -> None:
        """One step of one set, or of both; sets that are trained separately are also drawn so."""
        state, config, timed = self.state, self.config, self.state.history.timed
        rows = living_rows(state.dynamic, view.moment)
        static, dynamic = state.static, rows_taken(state.dynamic, rows)
        if ignored is not None and stage == "static":
            dynamic = dynamic.take(slice(0, 0))
        if ignored is not None and stage == "dynamic":
            static = static.take(slice(0, 0))
        seen = ScreenStatistics.zeros(len(static) + len(dynamic))
        with timed(f"{stage} step"):
            step = take_step(
                static,
                dynamic,
                view,
                config,
                gradients=stage,
                tiles=tiles,
                ignored=ignored,
                correction=state.correction,
                statistics=seen if self.schedule.are_pulls_counted(iteration) else None,
            )
        with timed("optimiser"):
            if stage in ("static", "all"):
                rates = self.schedule.static_rates(iteration)
                state.move_static(rates, seen.rows(slice(0, len(static))), config.density.static_opacity_penalty)
            if stage in ("dynamic", "all"):
                if state.time_shifts is not None and self.statics_learn:
                    state.time_shifts.step(view.place, dynamic, self.schedule.time_shift_rate(iteration))
                rates = self.schedule.dynamic_rates(iteration, dynamic)
                seen = seen.rows(slice(len(static), None))
                state.move_dynamic(dynamic, rows, rates, seen, config.density.dynamic_opacity_penalty)
            if step.colour_gradient is not None and stage != "dynamic" and self.statics_learn:
                assert state.correction is not None
                colour_rates = config.learning_rates.colour_correction, config.learning_rates.lens_falloff
                state.correction.step(view.place, step.colour_gradient, *colour_rates)
        if tiles is None and iteration % _REPORT_EVERY == 0:
            error = float((step.picture - view.target).square().mean())
            state.history.follow(step.loss, decibels(max(error, 1e-10)))

    def _constrain(self) -> None:
        """Keep colours displayable, lives no shorter than frames can tell, and needles short."""
        frames = max(2, self.segment.frames)
        sharpest = math.log(math.log(2) * ((frames - 1) / _SHORTEST_LIFE) ** 2)
        self.state.static.rgb.clamp_(0, 1)
        self.state.dynamic.rgb.clamp_(0, 1)
        self.state.dynamic.time_log_precisions.clamp_(max=sharpest)
        longest = self.config.elongation
        if self.backdrop is not None:
            longest = min(longest, _LONGEST_APART)
        _shorten_needles(self.state.dynamic.log_scales, longest)
        if self.statics_learn:
            _shorten_needles(self.state.static.log_scales, longest)


def _shorten_needles(log_scales: Tensor, elongation: float) -> None:
    """Let no axis [N, 3] be longer than `elongation` times the middle one, in place."""
    if len(log_scales):
        a, b, c = log_scales.unbind(1)
        middle = torch.maximum(torch.minimum(a, b), torch.minimum(torch.maximum(a, b), c))  # a median is far slower
        torch.minimum(log_scales, (middle + math.log(elongation))[:, None], out=log_scales)


def _copied(array: Tensor) -> npt.NDArray[np.float32]:
    return np.array(array.detach().numpy(), dtype=np.float32)
