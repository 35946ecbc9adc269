"""The two-stage trainer: in every cycle the statics learn on the composite, then the dynamics on the fresh one."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor

from hgs_core.camera import Camera
from hgs_core.capture.capture import Capture
from hgs_core.progress import Progress, ProgressCallback, StageStopped
from hgs_core.render.rasterize import rasterize
from hgs_core.render.threads import one_torch_thread
from hgs_core.render.tiles import tiles_of_dynamic, tiles_to_pixels
from hgs_core.render.types import Gradients, ScreenStatistics
from hgs_core.scene.splats import DynamicSplats, HybridScene, Segment, StaticSplats
from hgs_core.train.adam import Adam
from hgs_core.train.checkpoint import TrainState, load_state, save_state
from hgs_core.train.config import TrainConfig
from hgs_core.train.density import DensityRound, refine
from hgs_core.train.initialise import scene_extent
from hgs_core.train.loss import photometric_loss
from hgs_core.train.schedule import Schedule
from hgs_core.train.targets import target_picture
from hgs_core.train.views import ViewSchedule, training_cameras

__all__ = ["Trainer", "clock_of"]

_REPORT_EVERY = 10  # cycles
_SMOOTHING = 0.9  # of the reported PSNR
_SHORTEST_LIFE = 0.5  # frames at which the opacity of the briefest splat has halved


def clock_of(capture: Capture) -> Segment[npt.NDArray[np.float32]]:
    """Return the segment that spans the whole capture, without splats."""
    return Segment(float(capture.times[0]), float(capture.times[-1]), DynamicSplats.empty())


class Trainer:
    """Trains one segment of a capture.

    Args:
        capture: the whole capture; cameras held out by the config are never read.
        cameras: the capture's, with the near planes to train with.
        config: the run's config.
        start: first splats, ignored when `checkpoint` exists.
        checkpoint: where the state is kept.
    """

    def __init__(
        self,
        capture: Capture,
        cameras: Sequence[Camera],
        config: TrainConfig,
        start: tuple[StaticSplats[Tensor], DynamicSplats[Tensor]],
        checkpoint: Path,
    ) -> None:
        self.capture, self.cameras, self.config, self.checkpoint = capture, cameras, config, checkpoint
        training = training_cameras(capture, config)
        views = [cameras[i] for i in training]
        frame_bytes = max(3 * camera.width * camera.height for camera in views)
        # The decoder may pass frames that are not in the block: leave them a fifth of the cache.
        memory = (config.frame_memory_mib << 20) * 4 // 5
        self.views = ViewSchedule.fitting(training, len(capture.times), frame_bytes, memory, config.seed)
        self.extent = scene_extent(np.array([camera.position for camera in views]))
        self.schedule = Schedule(config, self.extent, len(capture.times))
        self.clock = clock_of(capture)
        self.first_counts = (len(start[0]), len(start[1]))
        self.state = load_state(checkpoint) if checkpoint.exists() else _fresh(*start)
        self._constrain()  # colours far out of range would leave Adam with second moments that stop it for long
        self.psnr = math.nan

    def run(self, progress: ProgressCallback) -> HybridScene[npt.NDArray[np.float32]]:
        """Train to the end of the schedule and return the scene.

        Raises:
            StageStopped: the callback asked to stop; the state was saved first.
        """
        started, before = time.monotonic(), self.state.seconds
        try:
            with one_torch_thread():
                while self.state.cycle < self.config.cycles:
                    self._cycle(self.state.cycle)
                    self.state.cycle += 1
                    self.state.seconds = before + time.monotonic() - started
                    if self.state.cycle % self.config.checkpoint_every == 0:
                        save_state(self.checkpoint, self.state)
                    if self.state.cycle % _REPORT_EVERY == 0 or self.state.cycle == self.config.cycles:
                        progress(Progress("train", self.state.cycle, self.config.cycles, self.figures()))
        except StageStopped:
            save_state(self.checkpoint, self.state)
            raise
        save_state(self.checkpoint, self.state)
        return self.scene()

    def figures(self) -> dict[str, float]:
        """Return what is worth watching."""
        figures = {"static": float(len(self.state.static)), "dynamic": float(len(self.state.dynamic))}
        return figures if math.isnan(self.psnr) else figures | {"psnr": self.psnr}

    def scene(self) -> HybridScene[npt.NDArray[np.float32]]:
        """Return a copy of the splats as they are now."""
        static, dynamic = self.state.static.map(_copied), self.state.dynamic.map(_copied)
        return HybridScene(static, (Segment(self.clock.start, self.clock.end, dynamic),))

    def _cycle(self, cycle: int) -> None:
        state = self.state
        index, frame = self.views.view(cycle)
        camera = self.cameras[index]
        factor = self.schedule.resolution(cycle)
        if factor != 1.0:
            camera = camera.scaled(factor)
        target = target_picture(self.capture, index, frame, camera)
        moment = self.clock.normalised(float(self.capture.times[frame]))
        if len(state.static):
            picture = self._learn("static", camera, moment, target, None)
            state.static_adam.step(state.static, self.schedule.static_rates(cycle))
            if cycle % _REPORT_EVERY == 0:
                self._follow_psnr(picture, target)
        tiles = tiles_of_dynamic(state.dynamic, camera, moment)
        if tiles.any():
            self._learn("dynamic", camera, moment, target, tiles)
            state.dynamic_adam.step(state.dynamic, self.schedule.dynamic_rates(cycle))
        self._constrain()
        if self.schedule.densifies_after(cycle):
            self._refine(cycle, 0.5 * max(camera.width, camera.height))

    def _learn(
        self, stage: Gradients, camera: Camera, moment: float, target: Tensor, tiles: npt.NDArray[np.bool_] | None
    ) -> Tensor:
        """One backward pass for one set; pixels outside `tiles` count as perfect."""
        state = self.state
        learning: StaticSplats[Tensor] | DynamicSplats[Tensor] = state.static if stage == "static" else state.dynamic
        learning.map(lambda array: array.requires_grad_(True))
        render = rasterize(
            state.static, state.dynamic, camera, moment,
            backend=self.config.backend, gradients=stage, tile_mask=tiles, statistics=state.statistics,
            antialiased=self.config.antialiased,
        )  # fmt: skip
        picture = render.rgb
        if tiles is not None:
            drawn = torch.from_numpy(tiles_to_pixels(tiles, camera.width, camera.height))
            picture = torch.where(drawn, picture, target)
        photometric_loss(picture, target, self.config.dssim).backward()  # type: ignore[no-untyped-call]
        learning.map(lambda array: array.requires_grad_(False))
        return picture.detach()

    def _follow_psnr(self, picture: Tensor, target: Tensor) -> None:
        psnr = -10 * math.log10(max(float((picture - target).square().mean()), 1e-10))
        self.psnr = psnr if math.isnan(self.psnr) else _SMOOTHING * self.psnr + (1 - _SMOOTHING) * psnr

    def _constrain(self) -> None:
        """Keep colours displayable and lives no shorter than frames can tell."""
        frames = max(2, len(self.capture.times))
        sharpest = math.log(math.log(2) * ((frames - 1) / _SHORTEST_LIFE) ** 2)
        self.state.static.rgb.clamp_(0, 1)
        self.state.dynamic.rgb.clamp_(0, 1)
        self.state.dynamic.time_log_precisions.clamp_(max=sharpest)

    def _refine(self, cycle: int, half_width: float) -> None:
        state, config = self.state, self.config
        statics = len(state.static)
        generator = torch.Generator().manual_seed(int(np.random.default_rng((config.seed, 3, cycle)).integers(2**62)))

        def plan(first: int, most: int) -> DensityRound:
            budget = self.schedule.budget(cycle, first, most)
            return DensityRound(budget, config.clone_scale * self.extent, half_width, config, generator)

        seen = state.statistics
        state.static = refine(
            state.static, state.static_adam, seen.rows(slice(0, statics)), plan(self.first_counts[0], config.max_static)
        )
        if len(state.dynamic):
            state.dynamic = refine(
                state.dynamic, state.dynamic_adam, seen.rows(slice(statics, None)),
                plan(self.first_counts[1], config.max_dynamic),
            )  # fmt: skip
        state.statistics = ScreenStatistics.zeros(len(state.static) + len(state.dynamic))


def _fresh(static: StaticSplats[Tensor], dynamic: DynamicSplats[Tensor]) -> TrainState:
    return TrainState(
        0, 0.0, static, dynamic, Adam.of(static), Adam.of(dynamic),
        ScreenStatistics.zeros(len(static) + len(dynamic)),
    )  # fmt: skip


def _copied(array: Tensor) -> npt.NDArray[np.float32]:
    return np.array(array.detach().numpy(), dtype=np.float32)
