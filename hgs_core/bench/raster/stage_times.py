"""How long the stages of a training iteration take, over repeats and after a warm-up."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Generic, NamedTuple, TypeVar

import numpy as np
import torch

from hgs_core.bench.raster.workload import BACKGROUND, Workload
from hgs_core.native.raster import Measurements, Raster
from hgs_core.render.rasterize import rasterize
from hgs_core.render.types import ScreenStatistics
from hgs_core.train.loss import photometric_loss
from hgs_core.train.rmsprop import RmsProp
from hgs_core.train.train_config import TrainConfig

__all__ = ["Timing", "TrainingTimes", "kernel_times", "training_times", "using_threads"]

WARM_UP = 3  # runs before the first that counts, fewer if they take longer than the timing itself
LEAST_REPEATS = 3


class TrainingTimes(NamedTuple):
    """Seconds of a training iteration, and of its parts as the trainer calls them."""

    iteration: float
    forward: float  # projection, binning and compositing
    loss: float  # its value and its gradient
    backward: float  # compositing and projection
    optimiser: float


Times = TypeVar("Times", TrainingTimes, Measurements)


@dataclass(frozen=True)
class Timing(Generic[Times]):
    """Figures over repeats: the median of each, and the least, which other work on the machine disturbs least."""

    median: Times
    least: Times
    repeats: int


@contextmanager
def using_threads(threads: int, backend: str) -> Iterator[None]:
    """Give the kernels `threads` threads and torch as many where it draws, else the one that training leaves it."""
    environment, torch_threads = os.environ.get("HGS_THREADS"), torch.get_num_threads()
    os.environ["HGS_THREADS"] = str(threads)
    torch.set_num_threads(threads if backend == "reference" else 1)
    try:
        yield
    finally:
        torch.set_num_threads(torch_threads)
        if environment is None:
            del os.environ["HGS_THREADS"]
        else:
            os.environ["HGS_THREADS"] = environment


def training_times(workload: Workload, backend: str, seconds: float) -> Timing[TrainingTimes]:
    """Time whole training iterations of the static set, made of the trainer's own functions.

    Loss and optimiser are the compiled ones where there are any, whatever the backend. The step size is zero: all the
    arithmetic is done, and every iteration sees the same scene.
    """
    static, dynamic = workload.static(), workload.dynamic()
    camera, moment = workload.camera, workload.scene.time
    dssim = TrainConfig().dssim
    optimiser, rates = RmsProp.of(static), {name: 0.0 for name, _ in static.items()}
    statistics = ScreenStatistics.zeros(len(static) + len(dynamic or ()))

    def iteration() -> TrainingTimes:
        start = time.perf_counter()
        static.map(lambda array: array.requires_grad_(True))
        render = rasterize(
            static,
            dynamic,
            camera,
            moment,
            background=BACKGROUND,
            backend=backend,
            gradients="static",
            statistics=statistics,
        )
        drawn = time.perf_counter()
        picture = render.rgb.detach().requires_grad_(True)
        (slope,) = torch.autograd.grad(photometric_loss(picture, workload.target, dssim), picture)
        compared = time.perf_counter()
        render.rgb.backward(slope)  # type: ignore[no-untyped-call]
        static.map(lambda array: array.requires_grad_(False))
        differentiated = time.perf_counter()
        optimiser.step(static, rates)
        end = time.perf_counter()
        parts = drawn - start, compared - drawn, differentiated - compared, end - differentiated
        return TrainingTimes(end - start, *parts)

    return _repeated(iteration, seconds)


def kernel_times(workload: Workload, seconds: float) -> Timing[Measurements]:
    """Time the compiled rasterizer's stages by its own clock, with gradients and statistics of the static set.

    The counts are the same in every run.
    """
    scene = workload.scene
    gradient = np.full(workload.target.shape, 1 / workload.target.numel(), np.float32)
    gradients = {name: np.empty_like(array) for name, array in scene.static.items()}
    statistics = ScreenStatistics.zeros(len(scene.static) + len(scene.dynamic or ()))

    def rendering() -> Measurements:
        raster = Raster(scene.static, scene.dynamic, workload.camera, scene.time, background=BACKGROUND)
        raster.backward(gradient, None, gradients, None, statistics=(statistics.pull_sum, statistics.count))
        measured = raster.measurements()
        raster.release()
        return measured

    return _repeated(rendering, seconds)


def _repeated(run: Callable[[], Times], seconds: float) -> Timing[Times]:
    """Run again and again for `seconds`, and at least three times."""
    deadline = time.perf_counter() + seconds
    for _ in range(WARM_UP):
        kind = type(run())
        if time.perf_counter() > deadline:
            break
    deadline = time.perf_counter() + seconds
    runs: list[Times] = []
    while len(runs) < LEAST_REPEATS or time.perf_counter() < deadline:
        runs.append(run())
    figures = np.array(runs)
    return Timing(kind(*np.median(figures, axis=0).tolist()), kind(*figures.min(axis=0).tolist()), len(runs))
