"""Settings of the rasterizers' benchmark."""

from __future__ import annotations

import math
from dataclasses import dataclass

from hgs_core.base.cores import core_count
from hgs_core.base.errors import InputError
from hgs_core.bench.raster.raster_sizes import DEFAULT_SIZES, Size
from hgs_core.native import library

__all__ = ["BACKENDS", "BenchSettings", "parse_backends", "parse_threads"]

BACKENDS = ("cpu", "reference")
MOST_THREADS = 1024


@dataclass(frozen=True)
class BenchSettings:
    """The matrix of a benchmark: every size with every number of threads and every backend.

    The reference backend runs at the sizes of `truth` alone: at the others it takes minutes and tens of gigabytes.
    """

    sizes: tuple[Size, ...]
    threads: tuple[int, ...]
    backends: tuple[str, ...]
    truth: tuple[Size, ...]  # sizes at which errors against the float64 reference are measured
    seconds: float  # time per point, after the warm-up
    dynamic_share: float  # share of splats, 0 to 0.9
    seed: int

    @staticmethod
    def of(
        *,
        sizes: tuple[Size, ...] = DEFAULT_SIZES,
        threads: tuple[int, ...] = (),
        backends: tuple[str, ...] = (),
        truth: tuple[Size, ...] | None = None,
        seconds: float = 1.0,
        dynamic_share: float = 0.0,
        seed: int = 0,
    ) -> BenchSettings:
        """Fill in the settings that depend on the machine or on other settings.

        Args:
            sizes: of scenes and pictures.
            threads: none given: 1 and all.
            backends: none given: those that this installation has.
            truth: None: those of `sizes` that are `affordable`.
            seconds: of timing per point.
            dynamic_share: share of the splats that move.
            seed: of the scenes.

        Raises:
            InputError: the cpu backend without compiled kernels, a truth size that is not measured, nothing to measure,
                or a number out of its range.
        """
        if not library.available() and "cpu" in backends:
            raise InputError(
                "--backends",
                "cpu needs the compiled kernels and there are none",
                "install a C++17 compiler and reinstall hgs, unset HGS_NATIVE_ISA, or ask for reference alone",
            )
        if not (math.isfinite(seconds) and seconds > 0):
            raise InputError("--seconds", f"{seconds} is not a positive number")
        if not 0 <= dynamic_share <= 0.9:
            raise InputError("--dynamic", f"{dynamic_share} is not a share from 0 to 0.9")
        if seed < 0:
            raise InputError("--seed", f"{seed} is negative")
        for size in truth or ():
            if size not in sizes:
                raise InputError("--truth", f"{size} is not measured", f"choose from {', '.join(map(str, sizes))}")
        backends = backends or (BACKENDS if library.available() else ("reference",))
        truth = tuple(size for size in sizes if size.affordable) if truth is None else truth
        if not truth and "cpu" not in backends:
            raise InputError(
                "--truth", "the reference backend runs at these sizes alone and there are none", "name one"
            )
        return BenchSettings(
            sizes=sizes,
            threads=threads or tuple(sorted({1, core_count()})),
            backends=backends,
            truth=truth,
            seconds=seconds,
            dynamic_share=dynamic_share,
            seed=seed,
        )


def parse_threads(where: str, text: str) -> tuple[int, ...]:
    """Read numbers of threads separated by commas, in ascending order.

    Raises:
        InputError: a text that is no number from 1 to 1024.
    """
    counts = set()
    for part in text.split(","):
        number = part.strip()
        if not (number.isascii() and number.isdecimal() and 1 <= int(number) <= MOST_THREADS):
            raise InputError(where, f"{number!r} is not a number from 1 to {MOST_THREADS}")
        counts.add(int(number))
    return tuple(sorted(counts))


def parse_backends(where: str, text: str) -> tuple[str, ...]:
    """Read names of backends separated by commas.

    Raises:
        InputError: an unknown name.
    """
    names = [part.strip() for part in text.split(",")]
    for name in names:
        if name not in BACKENDS:
            raise InputError(where, f"unknown backend {name!r}", f"choose from {', '.join(BACKENDS)}")
    return tuple(name for name in BACKENDS if name in names)
