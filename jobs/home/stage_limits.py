"""Limits of the stages of jobs: time without a report or computation, memory, processes and files."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from jobs.home.stage_settings import StageBytes, StageCount, StageSeconds

__all__ = ["StageLimits"]

_SILENCE = StageSeconds(300.0)
_REPORT = StageSeconds(7200.0, (("train", 3600.0), ("publish", 3600.0)))
_PROCESSES = StageCount(256)
_FILES = StageCount(4096)
_FILE_SIZE = StageBytes(100e9)


@dataclass(frozen=True)
class StageLimits:
    """The limits within which a worker lets each stage run."""

    silence: StageSeconds = _SILENCE  # longest time without report or computation
    report: StageSeconds = _REPORT  # longest time without report
    memory: StageBytes | None = None  # memory of each process; None: any
    processes: StageCount = _PROCESSES  # most processes; threads in proportion
    files: StageCount = _FILES  # most open files of each process
    file_size: StageBytes = _FILE_SIZE  # bytes of the longest file that it may write

    @classmethod
    def from_environment(cls, environment: Mapping[str, str]) -> StageLimits:
        """Read `HGS_STAGE_SILENCE` and `HGS_STAGE_REPORT`, in seconds, `HGS_STAGE_MEMORY` and `HGS_STAGE_FILE_SIZE`, in
        bytes, `HGS_STAGE_PROCESSES` and `HGS_STAGE_FILES`, in the forms of `jobs.home.stage_settings`.

        An empty variable counts as absent.

        Raises:
            InputError: a limit is not a positive number, or names an unknown stage.
        """
        given = {
            field: kind.parse(name, text)
            for field, (name, kind) in _VARIABLES.items()
            if (text := environment.get(name))
        }
        return cls(**given)  # type: ignore[arg-type]

    def environment(self) -> dict[str, str]:
        """Return the variables from which a child process reads these limits again."""
        return {name: str(getattr(self, field) or "") for field, (name, _) in _VARIABLES.items()}


_VARIABLES: Mapping[str, tuple[str, type[StageSeconds] | type[StageBytes] | type[StageCount]]] = {
    "silence": ("HGS_STAGE_SILENCE", StageSeconds),
    "report": ("HGS_STAGE_REPORT", StageSeconds),
    "memory": ("HGS_STAGE_MEMORY", StageBytes),
    "processes": ("HGS_STAGE_PROCESSES", StageCount),
    "files": ("HGS_STAGE_FILES", StageCount),
    "file_size": ("HGS_STAGE_FILE_SIZE", StageBytes),
}
