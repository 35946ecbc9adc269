"""The need of a training: memory, disk and time, as it is stated before the training and kept in its folder."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Self

from hgs_core.base.atomic import write_bytes
from hgs_core.base.cores import core_count

__all__ = ["TrainingNeed", "disk_words", "memory_words"]

_PARALLEL = 0.6  # share of the processor time that further cores shorten
_LONG = 120  # minutes from which on hours are stated


@dataclass(frozen=True)
class TrainingNeed:
    """The need of one training; `hgs_core.runs.training_costs` predicts it."""

    memory: Mapping[str, int]  # bytes of each stage's process, at most; stages of `hgs_core.runs.stages`
    pictures: int  # bytes of decoded pictures on disk
    files: int  # bytes of the run's other files
    processor: Mapping[str, float]  # seconds of all threads of each reported stage, in order
    course: tuple[float, ...]  # share of the time of `train` that is over after each of so many equal parts of it

    @property
    def most_memory(self) -> int:
        """Bytes of memory."""
        return max(self.memory.values())

    @property
    def disk(self) -> int:
        """Bytes on the disk of the run's folder."""
        return self.pictures + self.files

    def seconds(self, cores: int | None = None) -> dict[str, float]:
        """Return the seconds of the clock by reported stage on so many cores; None: those of this process."""
        faster = 1 - _PARALLEL + _PARALLEL / (cores or core_count())
        return {stage: seconds * faster for stage, seconds in self.processor.items()}

    def sentence(self, cores: int | None = None) -> str:
        """Return "needs 2.1 GiB of memory, 5 GB of disk and about 70 minutes here"."""
        minutes = sum(self.seconds(cores).values()) / 60
        time = f"{max(1, minutes):.0f} minutes" if minutes < _LONG else f"{minutes / 60:.0f} hours"
        memory, disk = memory_words(self.most_memory), disk_words(self.disk)
        return f"needs {memory} of memory, {disk} of disk and about {time} here"

    def save(self, path: Path) -> None:
        """Write a file of JSON.

        Raises:
            OSError: as `hgs_core.base.atomic.write_bytes`.
        """
        write_bytes(path, json.dumps(dataclasses.asdict(self)).encode())

    @classmethod
    def load(cls, path: Path) -> Self | None:
        """Read a file of `save`; None if it is missing or of another version."""
        try:
            value = json.loads(path.read_bytes())
            return cls(**value | {"course": tuple(value["course"])})
        except (OSError, ValueError, TypeError, KeyError):
            return None


def memory_words(size: float) -> str:
    """Return bytes as "2.1 GiB"."""
    return f"{size / 2**30:.1f} GiB"


def disk_words(size: float) -> str:
    """Return bytes as "35 MB", "0.4 GB" or "25 GB"."""
    if size < 1e8:
        return f"{max(1, size / 1e6):.0f} MB"
    return f"{size / 1e9:.1f} GB" if size < 9.95e9 else f"{size / 1e9:.0f} GB"
