"""What other ways to finish a training would bring: averages of its last steps, and Gauss-Newton steps.

    .venv/bin/python -m scripts.experiments.finishes CAPTURE OUT --hold-out 3,5,17 --score 5 [--set '{"seed": 1}']

A run is trained into OUT up to a share of its iterations, or taken from there if it is, and finished from this
checkpoint in several ways. Each is scored, not encoded, on the held-out cameras of `--score` and on pictures that it
trained on, as it ends and as the mean of its parameters over the last two thirds and the last third of the finish.

Since these were measured, trainings themselves hold their steps and end as the mean (`train.hold_from`,
`train.average_from`); here both are turned off, so that a finish does what it is called and nothing else.

Gauss-Newton steps are described in `gauss_newton.py`.
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import shutil
import time
from collections.abc import Iterator
from pathlib import Path

import torch
from torch import Tensor

from hgs_core.base.progress import Progress, StageStopped
from hgs_core.decompose.masks import MotionMasks
from hgs_core.evaluate.camera_scores import CameraScores, combine
from hgs_core.evaluate.picture_scores import PictureScorer
from hgs_core.evaluate.truth import Truth
from hgs_core.metrics.psnr import decibels
from hgs_core.points.near_plane import with_near_planes
from hgs_core.points.point_cloud import PointCloud
from hgs_core.render.fixed_view import FixedView
from hgs_core.runs import stages
from hgs_core.runs.run_config import RunConfig
from hgs_core.runs.run_folder import RunFolder
from hgs_core.scene.splats import DynamicSplats, StaticSplats
from hgs_core.train.capture_training import segment_trainer
from hgs_core.train.checkpoint import TrainState
from hgs_core.train.schedule import Schedule
from hgs_core.train.segment_cuts import cut_into_segments
from scripts.experiments.gauss_newton import Newton, NewtonSteps

_AVERAGES = (0.67, 0.33)  # last shares of the finish
_FALLING = {"train.hold_from": 1.0, "train.average_from": 1.0}


@dataclasses.dataclass(frozen=True)
class Finish:
    """A way to finish a training."""

    length: float = 1.0  # in multiples of the iterations that are left
    held: float | None = None  # all steps stay as they are at the checkpoint, times this; None: they fall
    statics: float = 1.0  # a further multiple of the statics' steps
    newton: Newton | None = None


FINISHES = {
    "steps fall": Finish(),
    "steps held": Finish(held=1.0),
    "steps held at 1.5 times": Finish(held=1.5),
    "steps held, those of statics at three times": Finish(held=1.0, statics=3.0),
    "three times as long": Finish(3.0),
    "Gauss-Newton, 0.003": Finish(0.77, newton=Newton(0.003, 0.1)),
    "Gauss-Newton, 0.01, damped by the mean": Finish(0.77, newton=Newton(0.01, 0.1, damping_by_mean=True)),
    "Gauss-Newton, 0.03": Finish(0.77, newton=Newton(0.03, 1.0)),
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("capture", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--hold-out", required=True)
    parser.add_argument("--score", required=True, help="those held-out cameras that are scored")
    parser.add_argument("--preset", default="standard")
    parser.add_argument("--set", default="{}", help="JSON of the config's fields")
    parser.add_argument("--share", type=float, default=0.85, help="of the iterations, before the finish")
    parser.add_argument("--masks", type=Path, help="what moves, where scores are taken; default: the capture's")
    parser.add_argument("--finish", action="append", choices=FINISHES, help="default: all")
    options = parser.parse_args()
    config = RunConfig.for_preset(options.preset, capture={"hold_out": options.hold_out.split(",")})
    config = config.changed(json.loads(options.set)).changed(_FALLING)
    _train_to(options.out, options.capture, config, options.share)
    training = _Training(options.out, options.score.split(","), options.masks)
    print("| | iterations | processor time | PSNR, mapped | moving, mapped | SSIM | moving | training views | moving |")
    print("|---|---|---|---|---|---|---|---|---|", flush=True)
    for name in options.finish or FINISHES:
        training.finish(name, FINISHES[name])


def _train_to(run: Path, capture: Path, config: RunConfig, share: float) -> None:
    """Train a run to a share of its iterations; nothing is done where there is one."""
    if RunFolder(run).checkpoint(0).exists():
        return

    def stop(progress: Progress) -> None:
        if progress.stage == "train" and progress.done >= share * progress.total:
            raise StageStopped("far enough")

    stages.create_run(run, capture, config)
    stages.initialise(run, stop)
    try:
        stages.train(run, stop)
    except StageStopped:
        return


class _Training:
    """A run that is trained in part, and what its finishes are scored against."""

    def __init__(self, run: Path, scored: list[str], masks: Path | None) -> None:
        self.folder = RunFolder(run)
        spec = self.folder.read_spec()
        self.config = spec.config.changed(_FALLING)  # the run may be older than these fields
        self.capture = spec.open_capture(cache_bytes=spec.config.capture.cache_bytes)
        self.points = PointCloud.load(self.folder.points)
        self.cameras = with_near_planes(self.capture.cameras, self.points.xyz)
        self.training = list(self.config.capture.training_cameras(self.capture))
        (self.segment,) = cut_into_segments(self.capture.times, self.config.train.segment_frames)
        self.scored = [self.capture.camera_index(name) for name in scored]
        self.fitted = self.training[1 :: max(1, len(self.training) // 4)][:4]
        self.truth = Truth(
            self.capture,
            [*self.scored, *self.fitted],
            pictures=None,
            masks=masks,
            downscale=self.config.capture.downscale,
        )

    def finish(self, name: str, how: Finish) -> None:
        """Finish the training and print its scores."""
        checkpoint = self.folder.path / "finish.pt"
        shutil.copy(self.folder.checkpoint(0), checkpoint)
        masks = MotionMasks.load(self.folder.masks, self.capture)
        trainer = segment_trainer(
            self.capture,
            {i: self.cameras[i] for i in self.training},
            self.config.train,
            self.config.seed,
            self.points,
            self.capture.frames_in(self.config.points.interval),
            checkpoint,
            self.segment,
            masks,
            None,
        )
        state, first = trainer.state, trainer.state.iteration
        count = round(how.length * (self.config.train.iterations - first))
        plan = trainer.schedule
        trainer.schedule = _FinishSchedule(
            plan.config,
            plan.extent,
            plan.frames,
            plan.seconds,
            first=first,
            count=count,
            held=how.held,
            statics=how.statics,
        )
        newton = None if how.newton is None else NewtonSteps(trainer, how.newton)
        means = [_Mean(first + round((1 - share) * count)) for share in _AVERAGES]
        started = time.process_time()
        for iteration in range(first, first + count):
            if newton is not None:
                newton.follow((iteration - first) / count)
            trainer._iteration(iteration)
            if (iteration + 1) % 10 == 0:
                for mean in means:
                    mean.follow(iteration, state)
        seconds = time.process_time() - started
        self._print(f"{name} | {count:,} | {seconds:.0f} s", state, state.static, state.dynamic)
        for share, mean in zip(_AVERAGES, means, strict=True):
            self._print(f"mean of the last {share:.0%} | |", state, *mean.splats())

    def _print(
        self, head: str, state: TrainState, static: StaticSplats[Tensor], dynamic: DynamicSplats[Tensor]
    ) -> None:
        unseen = combine([self._scores(camera, static, dynamic) for camera in self.scored])
        names = "psnr_colour_corrected", "psnr_dynamic_colour_corrected", "ssim", "ssim_dynamic"
        figures = [f"{unseen[name] or 0:.3f}" for name in names]
        fit, moving = self._fit(state, static, dynamic)
        print(f"| {head} | {' | '.join(figures)} | {fit:.3f} | {moving:.3f} |", flush=True)

    def _scores(self, camera: int, static: StaticSplats[Tensor], dynamic: DynamicSplats[Tensor]) -> CameraScores:
        scores = CameraScores(PictureScorer(None, False))
        for frame, picture in self._pictures(camera, static, dynamic, range(1, len(self.capture.times), 3)):
            scores.add(picture.clamp(0, 1), self.truth.picture(camera, frame), self.truth.moving(camera, frame))
        return scores

    def _fit(
        self, state: TrainState, static: StaticSplats[Tensor], dynamic: DynamicSplats[Tensor]
    ) -> tuple[float, float]:
        """Return the PSNR of pictures that were trained on, with their cameras' colours, and of what moves in them."""
        whole, moving = [], []
        for camera in self.fitted:
            frames = range(2, len(self.capture.times), max(1, len(self.capture.times) // 5))
            for frame, picture in self._pictures(camera, static, dynamic, frames):
                if state.correction is not None:
                    colours = state.correction.of(self.training.index(camera))
                    picture = colours.shown(picture, self.cameras[camera])
                error = (picture.clamp(0, 1) - self.truth.picture(camera, frame)).square().mean(0)
                whole.append(error.flatten())
                mask = self.truth.moving(camera, frame)
                moving.append(error[error < 0 if mask is None else mask])
        return decibels(float(torch.cat(whole).mean())), decibels(float(torch.cat(moving).mean()))

    def _pictures(
        self, camera: int, static: StaticSplats[Tensor], dynamic: DynamicSplats[Tensor], frames: range
    ) -> Iterator[tuple[int, Tensor]]:
        fixed = FixedView(static, self.cameras[camera], antialiased=self.config.train.antialiased)
        for frame in frames:
            moment = self.segment.clock.normalised(float(self.capture.times[frame]))
            yield frame, fixed.frame(dynamic, moment).rgb


@dataclasses.dataclass(frozen=True, kw_only=True)
class _FinishSchedule(Schedule):
    """The rest of a schedule, made shorter or longer, or held where it is."""

    first: int
    count: int
    held: float | None
    statics: float

    def static_rates(self, iteration: int) -> dict[str, float | Tensor]:
        return {name: self.statics * rate for name, rate in super().static_rates(iteration).items()}

    def settling(self, iteration: int) -> float:
        at, share = self._at(iteration)
        return share * super().settling(at)

    def position_rate(self, iteration: int) -> float:
        at, share = self._at(iteration)
        return share * super().position_rate(at)

    def _at(self, iteration: int) -> tuple[int, float]:
        """Return the iteration of the whole schedule whose steps are taken, and in which multiple."""
        if self.held is not None:
            return self.first, self.held
        left = self.config.iterations - self.first
        return self.first + round((iteration - self.first) * left / self.count), 1.0


class _Mean:
    """The mean of all parameters from an iteration on."""

    def __init__(self, first: int) -> None:
        self._first, self._count = first, 0
        self._sums: tuple[StaticSplats[Tensor], DynamicSplats[Tensor]] | None = None

    def follow(self, iteration: int, state: TrainState) -> None:
        if iteration < self._first:
            return
        self._count += 1
        if self._sums is None:
            self._sums = state.static.map(torch.Tensor.double), state.dynamic.map(torch.Tensor.double)
            return
        for sums, splats in zip(self._sums, (state.static, state.dynamic), strict=True):
            for name, array in splats.items():
                getattr(sums, name).add_(array)

    def splats(self) -> tuple[StaticSplats[Tensor], DynamicSplats[Tensor]]:
        assert self._sums is not None
        static, dynamic = (sums.map(lambda array: (array / self._count).float()) for sums in self._sums)
        return static, dynamic


if __name__ == "__main__":
    main()
