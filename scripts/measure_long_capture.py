"""The cost of each segment of a long capture: processor seconds and memory of the stages; prints a Markdown table.

    python -m scripts.make_large_capture samples/studio long --size 256x192 --frames 300 --cameras 6
    python -m scripts.measure_long_capture long --segments 10 --iterations 60

The run is of the preset `preview`, made and encoded segment by segment in one process, with the first camera held out.
"""

from __future__ import annotations

import argparse
import resource
import tempfile
import time
from collections import Counter
from pathlib import Path

from hgs_core.base.heap import trim_heap
from hgs_core.base.progress import Progress, silent
from hgs_core.capture.open import open_capture
from hgs_core.decompose.background import SAMPLED_FRAMES, sample_frames
from hgs_core.decompose.masks import mask_file
from hgs_core.runs.by_segment import assemble, finish, make_segment, segment_count
from hgs_core.runs.run_config import RunConfig
from hgs_core.runs.run_folder import RunFolder
from hgs_core.runs.stages import check, create_run, initialise, prepare

__all__ = ["Costs", "main"]

_SHARED = -1  # row of what is made once for all segments
_STAGES = ("check", "frames", "masks", "points", "train", "encode", "assemble", "finish")
_SHARED_POINTS = 2  # steps of the stage `points` before those of the segments


class Costs:
    """Processor seconds by stage and segment, and the most memory of each segment's training and encoding."""

    def __init__(self) -> None:
        self.seconds: Counter[tuple[str, int]] = Counter()
        self.memory: dict[int, int] = {}  # MiB
        self._last = time.process_time()

    def spent(self, stage: str, segment: int) -> None:
        """Count the processor time since the last call."""
        now = time.process_time()
        self.seconds[stage, segment] += now - self._last
        self._last = now

    def table(self, segments: int) -> str:
        """Return a row for all segments together, then one for each."""
        lines = [f"| segment | {' | '.join(_STAGES)} | most memory, MiB |", "|---" * (len(_STAGES) + 2) + "|"]
        for row in range(_SHARED, segments):
            cells = [f"{self.seconds[stage, row]:.2f}" if (stage, row) in self.seconds else "" for stage in _STAGES]
            name = "shared" if row == _SHARED else str(row)
            lines.append(f"| {name} | {' | '.join(cells)} | {self.memory.get(row, '')} |")
        return "\n".join(lines)


def _begin_memory() -> None:
    """Let the most memory count from now on, where the system can do that."""
    trim_heap()
    clear = Path("/proc/self/clear_refs")
    if clear.exists():
        clear.write_text("5")


def _most_memory() -> int:
    status = Path("/proc/self/status")
    if not status.exists():
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss >> 10
    return next(int(line.split()[1]) for line in status.read_text().splitlines() if line.startswith("VmHWM")) >> 10


def _measured(capture: Path, run: Path, segments: int, iterations: int) -> Costs:
    opened = open_capture(capture)
    frames = len(opened.times)
    first = opened.cameras[0].name
    config = RunConfig.for_preset("preview", capture={"hold_out": [first]}).changed(
        {
            "train.iterations": iterations,
            "train.segment_frames": -(-frames // segments),
            "points.static": 3000,
            "points.dynamic": 1500,
            "encode.by_segment": True,
        }
    )
    folder, backgrounds = RunFolder(run), len(sample_frames(frames, SAMPLED_FRAMES)) * (len(opened.cameras) - 1)
    create_run(run, capture, config)
    costs = Costs()

    def report(step: Progress) -> None:
        row = _SHARED
        if step.stage == "masks" and step.done > backgrounds:
            row = sum(mask_file(folder.masks, number).exists() for number in range(segments - 1))
        elif step.stage == "points" and step.done > _SHARED_POINTS:
            row = min(segments - 1, sum(file.stem.isdigit() for file in folder.points.iterdir()))
        costs.spent(step.stage if step.stage in _STAGES else "check", row)

    _begin_memory()
    prepare(run, report)
    check(run, report)
    costs.spent("check", _SHARED)
    initialise(run, report)
    costs.spent("points", _SHARED)
    costs.memory[_SHARED] = _most_memory()
    for number in range(segment_count(run)):
        _begin_memory()
        costs.spent("check", _SHARED)
        make_segment(run, number, lambda step, number=number: costs.spent("train", number))  # type: ignore[misc]
        costs.spent("encode", number)
        assemble(run)
        costs.spent("assemble", number)
        costs.memory[number] = _most_memory()
    _begin_memory()
    finish(run, silent)
    costs.spent("finish", _SHARED)
    print(f"most memory of finish: {_most_memory()} MiB")
    return costs


def main() -> None:
    """Measure, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("capture", type=Path)
    parser.add_argument("--segments", type=int, default=10)
    parser.add_argument("--iterations", type=int, default=60, help="of each segment")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        costs = _measured(given.capture, Path(folder) / "run", given.segments, given.iterations)
    print(costs.table(given.segments))


if __name__ == "__main__":
    main()
