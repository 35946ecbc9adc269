"""This checkout's training iteration beside another's: in turn, in one run, by processor time.

Each has a process of its own, run by its own interpreter, so that all code that an iteration passes through is its own.
"""

from __future__ import annotations

import json
import statistics
import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hgs_core.base.errors import InputError
from hgs_core.bench.raster.raster_settings import BenchSettings
from hgs_core.bench.raster.raster_sizes import Size
from hgs_core.bench.raster.stage_times import TrainingTimes

__all__ = ["ROUNDS", "Comparison", "compare", "interpreter_of"]

ROUNDS = 9  # odd, so that the median is a round's


@dataclass(frozen=True)
class Comparison:
    """A training iteration of this checkout and of another, of the cpu backend at one size."""

    size: str
    threads: int
    rounds: int
    here: TrainingTimes  # seconds of processor time, of all threads; the median of the rounds
    other: TrainingTimes
    speed: TrainingTimes  # how many times as fast this one is; the median of the rounds
    slowest: TrainingTimes  # the same in the rounds where it was least
    fastest: TrainingTimes
    errors_here: Mapping[str, float] | None  # "image" and the gradients by name; at the sizes of `truth`
    errors_other: Mapping[str, float] | None


def interpreter_of(checkout: Path) -> Path:
    """Return the Python of an installed checkout.

    Raises:
        InputError: there is none.
    """
    python = checkout / ".venv" / "bin" / "python"
    if not python.is_file():
        raise InputError("--against", f"{checkout} has no .venv/bin/python", "run scripts/install there")
    return python.absolute()  # not resolved: a virtual environment is found by the place of its link


def compare(settings: BenchSettings, python: Path, size: Size, threads: int, rounds: int = ROUNDS) -> Comparison:
    """Measure both in turn, `settings.seconds` of processor time each, split over the rounds.

    Raises:
        InputError: the other checkout does not run, or cannot do what is asked.
    """
    start = {
        "size": (size.splats, size.width, size.height),
        "threads": threads,
        "seed": settings.seed,
        "dynamic_share": settings.dynamic_share,
    }
    with ExitStack() as stack:
        here, other = (stack.enter_context(_measuring(path, start)) for path in (Path(sys.executable), python))
        found = [process.ask({}) if size in settings.truth else None for process in (here, other)]
        times: list[tuple[TrainingTimes, TrainingTimes]] = []
        for number in range(rounds):
            request = {"seconds": settings.seconds / rounds}
            pair = {p: p.ask(request) for p in ((here, other) if number % 2 else (other, here))}
            times.append((TrainingTimes(**pair[here]), TrainingTimes(**pair[other])))
    ratios = [tuple(b / a for a, b in zip(*pair, strict=True)) for pair in times]
    return Comparison(
        str(size),
        threads,
        rounds,
        _each(statistics.median, [one for one, _ in times]),
        _each(statistics.median, [two for _, two in times]),
        _each(statistics.median, ratios),
        _each(min, ratios),
        _each(max, ratios),
        *found,
    )


def _each(function: Any, rounds: list[Any]) -> TrainingTimes:
    return TrainingTimes(*(float(function(column)) for column in zip(*rounds, strict=True)))


class _Process:
    """A process that measures when it is asked to."""

    def __init__(self, process: subprocess.Popen[str], python: Path) -> None:
        self._process, self._python = process, python

    def ask(self, request: Mapping[str, Any], answered: bool = True) -> dict[str, float]:
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        try:
            self._process.stdin.write(json.dumps(request) + "\n")
            self._process.stdin.flush()
            line = self._process.stdout.readline() if answered else "{}"
            return dict(json.loads(line))
        except (OSError, ValueError):
            raise InputError("--against", f"{self._python} could not measure: its error is above") from None


@contextmanager
def _measuring(python: Path, start: Mapping[str, Any]) -> Iterator[_Process]:
    script = Path(__file__).with_name("iteration_times.py")
    # -P: the folder of the script is not where its imports are looked for.
    with subprocess.Popen(
        [str(python), "-P", str(script)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        cwd=python.parents[2],
    ) as child:
        process = _Process(child, python)
        try:
            process.ask(start, answered=False)
            yield process
        finally:
            assert child.stdin is not None
            with suppress(OSError):  # it may have ended before it read everything
                child.stdin.close()
