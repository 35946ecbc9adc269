"""Print the table of hard cases, measured on this machine; docs/numerics.md quotes the worst.

    .venv/bin/python scripts/hard_cases.py

The cases are those of tests/hgs_core/render/hard_cases.py, which the test suite holds to the bounds.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

import torch

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from hgs_core.native import library  # noqa: E402
from tests.hgs_core.render.comparison import Result, differentiate, relative_error  # noqa: E402
from tests.hgs_core.render.hard_cases import CASES, HardCase  # noqa: E402

REPEATS = 3


def measured(backend: str, dtype: torch.dtype, case: HardCase) -> tuple[Result, float]:
    """A rendering and its derivative, and the least milliseconds of processor time that they took."""
    least = float("inf")
    for _ in range(REPEATS):
        begin = time.process_time()
        result = differentiate(backend, dtype, case.static, case.dynamic, case.view)
        least = min(least, time.process_time() - begin)
    return result, 1e3 * least


def errors(result: Result, truth: Result) -> tuple[float, float, float]:
    """The worst relative L2 error of a picture, the worst pixel of alpha, and the worst error of a gradient."""
    pictures, gradients = result.pictures(), result.gradients()
    return (
        max(relative_error(pictures[name], image) for name, image in truth.pictures().items()),
        float((pictures["alpha"].double() - truth.pictures()["alpha"]).abs().max()),
        max((relative_error(gradients[name], g) for name, g in truth.gradients().items()), default=0.0),
    )


def table() -> str:
    lines = [
        "| case | image | bound | pixel | gradient | bound "
        "| reference float32: image, pixel, gradient | ms: cpu, float64 |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for name, make in CASES.items():
        case = make()
        truth, slow = measured("reference", torch.float64, case)
        fast, milliseconds = measured("cpu", torch.float32, case)
        image, pixel, gradient = errors(fast, truth)
        other = errors(measured("reference", torch.float32, case)[0], truth)
        lines.append(
            f"| {name.replace('_', ' ')} | {image:.1e} | {case.image:.0e} | {pixel:.1e} | {gradient:.1e} "
            f"| {case.gradient:.0e} | {other[0]:.1e}, {other[1]:.1e}, {other[2]:.1e} | {milliseconds:.1f}, {slow:.1f} |"
        )
    return "\n".join(lines) + "\n"


def main() -> None:
    argparse.ArgumentParser(description=__doc__.splitlines()[0]).parse_args()
    if library.instruction_set() is None:
        sys.exit("the table compares the compiled kernels, and there are none: see scripts/install")
    torch.set_num_threads(1)
    print(table(), end="")


if __name__ == "__main__":
    main()
