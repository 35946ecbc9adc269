"""The growth of each stage of a training with frames, pixels and cameras (docs/benchmarks.md, "Large captures").

    python -m scripts.measure_growth samples/studio FOLDER

Makes four captures of one (`scripts.make_large_capture`): a base, and others with more frames, pixels or cameras. Each
is trained for a few iterations (`hgs bench train`). A cost that grows with the square of the pixels has exponent 2.
"""

from __future__ import annotations

import argparse
import json
import math
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

__all__ = ["main"]

_BASE = {"frames": 60, "pixels": 512 * 384, "cameras": 8}
_GROWN = {"frames": 240, "pixels": 1024 * 768, "cameras": 16}
_SIDES = {512 * 384: "512x384", 1024 * 768: "1024x768"}
_STAGES = ("sync", "check", "frames", "masks", "points")


def _costs(source: Path, folder: Path, wanted: dict[str, int], options: Sequence[str]) -> dict[str, float]:
    """Return the seconds of processor time of each stage; a report that stands in the folder is not measured again."""
    name = "-".join(str(value) for value in wanted.values())
    report = folder / f"{name}.json"
    if not report.exists():
        made = ["--size", _SIDES[wanted["pixels"]], "--frames", wanted["frames"], "--cameras", wanted["cameras"]]
        _run("scripts.make_large_capture", source, folder / name, *made)
        bench = ["bench", "train", folder / name, "--preset", "standard", "--hold-out", "cam00", "--json", report]
        _run("server.cli", *bench, *options)
    found: dict[str, float] = {}
    for cost in json.loads(report.read_text())["stages"]:
        found[cost["stage"]] = found.get(cost["stage"], 0.0) + cost["processor_seconds"]
    return found


def _run(module: str, *words: object) -> None:
    subprocess.run([sys.executable, "-m", module, *map(str, words)], check=True, stdout=sys.stderr)


def main() -> None:
    """Print a table of costs and exponents."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("source", type=Path, help="a capture of LLFF's layout, with videos")
    parser.add_argument("folder", type=Path, help="for captures and reports")
    given = parser.parse_args()
    given.folder.mkdir(parents=True, exist_ok=True)
    options = ["--trust-poses", "--set", "train.iterations=60"]
    base = _costs(given.source, given.folder, _BASE, options)
    grown = {name: _costs(given.source, given.folder, _BASE | {name: value}, options) for name, value in _GROWN.items()}
    print("| | s | " + " | ".join(f"{value / _BASE[name]:g} x {name}" for name, value in _GROWN.items()) + " |")
    print("|" + "---|" * (2 + len(_GROWN)))
    for stage in _STAGES:
        cells = [f"{base[stage]:.1f}"]
        for name, costs in grown.items():
            times = _GROWN[name] / _BASE[name]
            exponent = math.log(costs[stage] / base[stage]) / math.log(times)
            cells.append(f"{costs[stage]:.1f} s, {exponent:.2f}")
        print(f"| {stage} | " + " | ".join(cells) + " |")


if __name__ == "__main__":
    main()
