"""Speed and error of the rasterizers over a matrix of sizes, backends and numbers of threads."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from hgs_core.base.progress import Progress, ProgressCallback
from hgs_core.bench.raster.accuracy import Errors, errors
from hgs_core.bench.raster.operations import Operations
from hgs_core.bench.raster.raster_settings import BenchSettings
from hgs_core.bench.raster.stage_times import kernel_times, training_times, using_threads
from hgs_core.bench.raster.workload import Workload
from hgs_core.native.machine import machine_facts
from hgs_core.native.peak import fma_peak
from hgs_core.native.raster import Measurements

__all__ = ["STAGES", "Point", "RasterReport", "Scaling", "Speedup", "Work", "bench_raster"]

STAGES = ("project", "bin", "forward", "loss", "backward", "optimiser")


@dataclass(frozen=True)
class Work:
    """The work of the compiled rasterizer for one picture, and its speed."""

    visible_static: int
    visible_dynamic: int
    tile_entries: int  # pairs of a splat and a tile it touches
    evaluations: int  # pairs of a splat and a pixel, whole vectors; backward, without dynamics, has as many
    evaluations_per_second: Mapping[str, float]  # "forward" and "backward", of compositing alone
    share_of_peak: Mapping[str, float]  # the same in operations, as a share of the machine's own FMA peak


@dataclass(frozen=True)
class Point:
    """One backend at one size with one number of threads. Times are medians in seconds."""

    size: str
    splats: int  # splats of both sets
    width: int  # pixels
    height: int  # pixels
    backend: str
    threads: int
    repeats: int  # whole iterations timed
    iteration: float  # a whole training iteration
    iteration_least: float  # the shortest one
    iterations_per_second: float
    forward_backward: float  # the part of it that draws and differentiates, called as the trainer does
    stages: Mapping[str, float | None]  # STAGES; of the reference, project and bin are in forward
    backward_parts: Mapping[str, float] | None  # composite_backward and project_backward, of the cpu backend
    work: Work | None  # the cpu backend's only
    errors: Errors | None  # only at the sizes of `truth`


@dataclass(frozen=True)
class Speedup:
    """How many times as long as the cpu backend the batched torch path takes to draw and differentiate."""

    size: str
    threads: int
    reference_over_cpu: float


@dataclass(frozen=True)
class Scaling:
    """How many times as fast more threads are than the fewest measured."""

    size: str
    backend: str
    threads: int
    against: int  # threads
    iteration: float
    stages: Mapping[str, float | None]


@dataclass(frozen=True)
class RasterReport:
    """All of a benchmark's results."""

    machine: Mapping[str, str | int | float | None]
    settings: BenchSettings
    operations: Operations  # operations of one evaluation
    fma_peaks: Mapping[int, float]  # threads -> floating-point operations per second; empty without kernels
    points: tuple[Point, ...]
    speedups: tuple[Speedup, ...]
    scaling: tuple[Scaling, ...]

    def to_json(self) -> dict[str, Any]:
        """Return plain dictionaries, lists, strings and numbers."""
        plain = dataclasses.asdict(self)
        for name in ("sizes", "truth"):
            plain["settings"][name] = [str(size) for size in getattr(self.settings, name)]
        return plain


def bench_raster(settings: BenchSettings, progress: ProgressCallback) -> RasterReport:
    """Measure the whole matrix; `progress` is called after every point."""
    machine = machine_facts()
    peaks = {threads: fma_peak(threads) for threads in settings.threads} if "cpu" in settings.backends else {}
    backends = {
        size: [backend for backend in settings.backends if backend == "cpu" or size in settings.truth]
        for size in settings.sizes
    }
    total = sum(len(names) for names in backends.values()) * len(settings.threads)
    points: list[Point] = []
    for size in settings.sizes:
        workload = Workload.of(size, settings.seed, settings.dynamic_share)
        found: dict[str, Errors] = {}
        if size in settings.truth:
            with using_threads(max(settings.threads), "reference"):
                found = errors(workload, backends[size])
        for backend in backends[size]:
            for threads in settings.threads:
                with using_threads(threads, backend):
                    points.append(_measure(workload, backend, threads, settings.seconds, peaks, found.get(backend)))
                progress(Progress("bench", len(points), total, {"splats": size.splats, "threads": threads}))
    return RasterReport(machine, settings, Operations(), peaks, tuple(points), _speedups(points), _scaling(points))


def _measure(
    workload: Workload, backend: str, threads: int, seconds: float, peaks: Mapping[int, float], found: Errors | None
) -> Point:
    timing = training_times(workload, backend, seconds)
    training = timing.median
    stages: dict[str, float | None] = {
        "project": None,
        "bin": None,
        "forward": training.forward,
        "loss": training.loss,
        "backward": training.backward,
        "optimiser": training.optimiser,
    }
    parts, work = None, None
    if backend == "cpu":
        kernels = kernel_times(workload, seconds).median
        parts = {"composite_backward": kernels.composite_backward, "project_backward": kernels.project_backward}
        stages |= {
            "project": kernels.project,
            "bin": kernels.bin,
            "forward": kernels.composite,
            "backward": kernels.composite_backward + kernels.project_backward,
        }
        work = _work(kernels, peaks[threads])
    size = workload.size
    return Point(
        size=str(size),
        splats=size.splats,
        width=size.width,
        height=size.height,
        backend=backend,
        threads=threads,
        repeats=timing.repeats,
        iteration=training.iteration,
        iteration_least=timing.least.iteration,
        iterations_per_second=1 / training.iteration,
        forward_backward=training.forward + training.backward,
        stages=stages,
        backward_parts=parts,
        work=work,
        errors=found,
    )


def _work(kernels: Measurements, peak: float) -> Work:
    operations = Operations()
    rates = {
        "forward": kernels.evaluations / kernels.composite,
        "backward": kernels.evaluations / kernels.composite_backward,
    }
    return Work(
        int(kernels.visible_static),
        int(kernels.visible_dynamic),
        int(kernels.tile_entries),
        int(kernels.evaluations),
        rates,
        {part: rate * getattr(operations, part) / peak for part, rate in rates.items()},
    )


def _speedups(points: list[Point]) -> tuple[Speedup, ...]:
    compiled = {(p.size, p.threads): p.forward_backward for p in points if p.backend == "cpu"}
    return tuple(
        Speedup(p.size, p.threads, p.forward_backward / compiled[p.size, p.threads])
        for p in points
        if p.backend == "reference" and (p.size, p.threads) in compiled
    )


def _scaling(points: list[Point]) -> tuple[Scaling, ...]:
    fewest: dict[tuple[str, str], Point] = {}
    found = []
    for point in points:
        base = fewest.setdefault((point.size, point.backend), point)  # threads ascend
        if base is not point:
            ratios = {name: _ratio(base.stages[name], point.stages[name]) for name in STAGES}
            ratio = base.iteration / point.iteration
            found.append(Scaling(point.size, point.backend, point.threads, base.threads, ratio, ratios))
    return tuple(found)


def _ratio(one: float | None, other: float | None) -> float | None:
    return one / other if one and other else None
