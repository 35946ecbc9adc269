"""The coefficients of hgs_core/runs/training_costs.py, from reports of measured trainings.

    hgs bench train CAPTURE --preset standard --hold-out cam00 --set train.iterations=400 --json REPORT.json
    python -m scripts.fit_training_costs REPORT.json... --check OTHER.json...

Non-negative least squares of the relative errors. Of `--check` only predictions are printed, beside the measurements.
"""

from __future__ import annotations

import argparse
import itertools
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from hgs_core.runs.run_config import RunConfig
from hgs_core.runs.training_costs import COSTS, MEMORY, held_pictures, memory_terms, terms
from hgs_core.runs.training_size import SegmentSize, TrainingSize

__all__ = ["main"]

_STEPS = ("all step", "static step", "dynamic step", "optimiser", "frames")  # activities of an iteration
_MOVING = "moving steps"


def _size(report: Mapping[str, Any]) -> TrainingSize:
    segments = tuple(SegmentSize(**one) for one in report["size"]["segments"])
    return TrainingSize(**report["size"] | {"segments": segments})


def _seconds(report: Mapping[str, Any]) -> dict[str, float]:
    """Return the seconds of processor time by part: those of `train` divided as the clock's are."""
    found: dict[str, float] = {}
    for cost in report["stages"]:
        found[cost["stage"]] = found.get(cost["stage"], 0.0) + cost["processor_seconds"]
    profile = report["profile"]
    train, whole = found.pop("train"), sum(profile.values())
    moving = profile.get(_MOVING, 0.0) / whole
    steps = sum(profile.get(name, 0.0) for name in _STEPS) / whole
    found |= {"steps": train * steps, "moving": train * moving, "rounds": train * (1 - steps - moving)}
    # A short training may have no time for a part: nothing is to be learnt of it there.
    return {part: found[part] for part in COSTS if found.get(part)}


def _memory(report: Mapping[str, Any]) -> dict[str, float]:
    """Return the most memory at the end of each stage, MiB."""
    most = {cost["stage"]: cost["most_memory"] / 2**20 for cost in report["stages"]}
    return {"initialise": most["points"], "train": most["train"], "encode": most["encode"]}


def _fitted(rows: Sequence[Sequence[float]], measured: Sequence[float]) -> npt.NDArray[np.float64]:
    """Return the coefficients, none below 0, of the least squares of relative errors: the best of all subsets."""
    matrix = np.array(rows) / np.array(measured)[:, None]
    best, least = np.zeros(matrix.shape[1]), np.inf
    for count in range(1, matrix.shape[1] + 1):
        for chosen in map(list, itertools.combinations(range(matrix.shape[1]), count)):
            found = np.linalg.lstsq(matrix[:, chosen], np.ones(len(rows)), rcond=None)[0]
            error = float(np.square(matrix[:, chosen] @ found - 1).sum())
            if (found >= 0).all() and error < least - 1e-9:
                best, least = np.zeros(matrix.shape[1]), error
                best[chosen] = found
    return best


def main() -> None:
    """Print coefficients, and predictions beside measurements."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("reports", nargs="+", type=Path)
    parser.add_argument("--check", nargs="+", type=Path, default=[])
    given = parser.parse_args()
    fitted = [json.loads(path.read_text()) for path in given.reports]
    others = [json.loads(path.read_text()) for path in given.check]
    kinds = ((_seconds, lambda one: terms(_size(one)), COSTS, "s"), (_memory, _memory_terms, MEMORY, "MiB"))
    for wanted, grown, known, unit in kinds:
        for part in known:
            own = [report for report in (*fitted, *others) if part in wanted(report)]
            if not own:
                continue
            rows = [grown(report)[part] for report in own]
            measured = [wanted(report)[part] for report in own]
            count = sum(report in fitted for report in own)
            found = _fitted(rows[:count], measured[:count])
            print(f'"{part}": ({", ".join(f"{one:.3g}" for one in found)}),', "  # measured, fitted, in the program")
            for row, value in zip(rows, measured, strict=True):
                print(f"    {value:8.1f} {np.dot(row, found):8.1f} {np.dot(row, known[part]):8.1f} {unit}")


def _memory_terms(report: Mapping[str, Any]) -> dict[str, tuple[float, ...]]:
    size = _size(report)
    return memory_terms(size, held_pictures(size, RunConfig.from_json(report["config"])))


if __name__ == "__main__":
    main()
