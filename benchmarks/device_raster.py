"""Speed, memory and error of the rasterizers of a CUDA device: Triton's, and gsplat's as a comparator."""

from __future__ import annotations

import argparse
import dataclasses
import importlib.util
import statistics
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import torch
from torch import Tensor

from benchmarks.refusals import refusing
from hgs_core.base.errors import InputError
from hgs_core.base.progress import Progress, ProgressCallback
from hgs_core.bench.raster.accuracy import errors
from hgs_core.bench.raster.raster_sizes import Size, parse_sizes
from hgs_core.bench.raster.workload import BACKGROUND, Workload
from hgs_core.native.machine import machine_facts
from hgs_core.render.rasterize import rasterize
from hgs_core.render.triton.device import require_device
from hgs_core.scene.splats import StaticSplats
from server.cli.json_output import JsonOutput
from server.cli.progress_bars import ProgressBars

__all__ = ["DEVICE_SIZES", "DevicePoint", "DeviceReport", "bench_device_raster", "device_report_text", "main"]

DEVICE_SIZES = tuple(
    Size(splats, width, height)
    for splats in (50_000, 200_000, 1_000_000)
    for width, height in ((1352, 1014), (3840, 2160))
)
_WARM_UP, _LEAST_REPEATS = 2, 3

Draw = Callable[[StaticSplats[Tensor], Workload], Tensor]


@dataclass(frozen=True)
class DevicePoint:
    """One rasterizer at one size; times are medians, the device awaited."""

    size: str
    rasterizer: str
    repeats: int
    forward: float  # seconds
    forward_backward: float  # seconds
    peak_bytes: int | None  # device memory beyond the scene's, drawing and differentiating; None without CUDA
    image_error: float  # relative L2 against the float64 reference
    gradient_error: float | None  # the worst of the parameters'; None where the reference's graph is too large


@dataclass(frozen=True)
class DeviceReport:
    """All of a benchmark's results."""

    machine: Mapping[str, str | int | float | None]
    points: tuple[DevicePoint, ...]

    def to_json(self) -> dict[str, Any]:
        """Return plain dictionaries, lists, strings and numbers."""
        return dataclasses.asdict(self)


def bench_device_raster(
    sizes: tuple[Size, ...], seconds: float, seed: int, against: str | None, progress: ProgressCallback
) -> DeviceReport:
    """Measure Triton, and "gsplat" if `against` says so, on scenes of statics.

    Raises:
        InputError: no Triton or no CUDA device, or an unknown or missing comparator.
    """
    device = require_device()
    rasterizers: dict[str, Draw] = {"triton": _draw_triton}
    if against is not None:
        rasterizers[against] = _comparator(against)
    cuda = device.type == "cuda"
    machine = machine_facts() | {"device": torch.cuda.get_device_name(device) if cuda else "Triton's interpreter"}
    points: list[DevicePoint] = []
    for size in sizes:
        workload = Workload.of(size, seed, 0.0)
        with torch.no_grad():
            truth = _draw(workload.static(torch.float64).map(lambda array: array.to(device)), workload, "reference")
        for name, draw in rasterizers.items():
            points.append(_measure(workload, name, draw, truth, device, seconds))
            progress(Progress("bench", len(points), len(sizes) * len(rasterizers), {"splats": size.splats}))
        del truth
    return DeviceReport(machine, tuple(points))


def _measure(
    workload: Workload, name: str, draw: Draw, truth: Tensor, device: torch.device, seconds: float
) -> DevicePoint:
    static = workload.static().map(lambda array: array.to(device).requires_grad_(True))
    slope = torch.ones(workload.target.shape, device=device) / workload.target.numel()
    before = torch.cuda.memory_allocated(device) if device.type == "cuda" else 0

    def forward() -> Tensor:
        return draw(static, workload)

    def both() -> None:
        forward().backward(slope)  # type: ignore[no-untyped-call]
        for _, array in static.items():
            array.grad = None

    with torch.no_grad():
        image = forward()
        error = float((image.double() - truth).norm() / truth.norm())
        drawn, repeats = _median(forward, device, seconds)
    if device.type == "cuda":
        torch.cuda.reset_peak_memory_stats(device)
    differentiated, _ = _median(both, device, seconds)
    peak = torch.cuda.max_memory_allocated(device) - before if device.type == "cuda" else None
    worst = None
    if name == "triton" and workload.size.affordable:
        worst = max(errors(workload, [name])[name].gradients.values())
    return DevicePoint(str(workload.size), name, repeats, drawn, differentiated, peak, error, worst)


def _median(run: Callable[[], object], device: torch.device, seconds: float) -> tuple[float, int]:
    """Return the median time of a run, the device awaited, and the number of runs."""

    def timed() -> float:
        started = time.perf_counter()
        run()
        if device.type == "cuda":
            torch.cuda.synchronize(device)
        return time.perf_counter() - started

    for _ in range(_WARM_UP):
        timed()
    times: list[float] = []
    while len(times) < _LEAST_REPEATS or sum(times) < seconds:
        times.append(timed())
    return statistics.median(times), len(times)


def _draw(static: StaticSplats[Tensor], workload: Workload, backend: str) -> Tensor:
    return rasterize(static, None, workload.camera, background=BACKGROUND, backend=backend).rgb


def _draw_triton(static: StaticSplats[Tensor], workload: Workload) -> Tensor:
    return _draw(static, workload, "triton")


def _comparator(name: str) -> Draw:
    """Return another rasterizer; it is imported only here, because gsplat builds its kernels when it is imported."""
    if name != "gsplat":
        raise InputError("--against", f"unknown rasterizer {name!r}", "use gsplat")
    if importlib.util.find_spec("gsplat") is None:
        raise InputError("--against", "gsplat is not installed", "pip install gsplat==1.5.3")
    from gsplat import rasterization

    def draw(static: StaticSplats[Tensor], workload: Workload) -> Tensor:
        camera, device = workload.camera, static.rgb.device
        pose = torch.tensor(camera.world_to_camera, dtype=torch.float32, device=device)
        lens = torch.tensor([[camera.fx, 0, camera.cx], [0, camera.fy, camera.cy], [0, 0, 1]], device=device)
        image = rasterization(
            static.means,
            static.quats,
            static.log_scales.exp(),
            static.opacity_logits.sigmoid(),
            static.rgb,
            pose[None],
            lens[None].float(),
            camera.width,
            camera.height,
            near_plane=camera.near,
            backgrounds=torch.tensor([BACKGROUND], device=device),
            packed=False,
        )[0]
        planes: Tensor = image[0].permute(2, 0, 1)
        return planes

    return draw


def device_report_text(report: DeviceReport) -> str:
    """Return the table of a report."""
    lines = [f"{report.machine['device']}, torch {report.machine['torch']}", ""]
    lines.append(
        f"{'size':<18}{'rasterizer':<12}{'forward ms':>12}{'with backward':>15}{'peak MiB':>10}"
        f"{'image error':>13}{'gradient':>10}"
    )
    for p in report.points:
        peak = "-" if p.peak_bytes is None else f"{p.peak_bytes / 2**20:.0f}"
        gradient = "-" if p.gradient_error is None else f"{p.gradient_error:.1e}"
        times = f"{p.forward * 1e3:>12.2f}{p.forward_backward * 1e3:>15.2f}"
        lines.append(f"{p.size:<18}{p.rasterizer:<12}{times}{peak:>10}{p.image_error:>13.1e}{gradient:>10}")
    return "\n".join(lines)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the benchmark and return the exit status."""
    parser = argparse.ArgumentParser(prog="benchmarks.device_raster", description=__doc__)
    parser.add_argument("--json", metavar="FILE", nargs="?", const="-", help="write JSON to FILE or standard output")
    parser.add_argument("--sizes", metavar="LIST", help="splats and pixels, like 20k@676x507,100k@1352x1014")
    parser.add_argument("--against", metavar="RASTERIZER", help="gsplat, if it is installed")
    parser.add_argument("--seconds", metavar="S", type=float, default=1.0, help="of timing per point (default: 1)")
    parser.add_argument("--seed", metavar="N", type=int, default=0, help="seed of the scenes (default: 0)")
    options = parser.parse_args(arguments)

    def run() -> int:
        sizes = DEVICE_SIZES if options.sizes is None else parse_sizes("--sizes", options.sizes)
        output = JsonOutput(options.json)
        with ProgressBars() as bars:
            report = bench_device_raster(sizes, options.seconds, options.seed, options.against, bars)
        output.show(report.to_json(), device_report_text(report))
        return 0

    return refusing(run)


if __name__ == "__main__":
    sys.exit(main())
