"""The sandbox of a job's stage: its run, its capture and its given files, and no network.

Stages that reach the store and the database have none. Nor have those of a machine with a GPU: its drivers open files
all over the system.
"""

from __future__ import annotations

import json
import tempfile
from pathlib import Path

from hgs_core.runs.given_files import GivenFiles
from jobs.home.home import Home
from jobs.process.sandbox import enter_sandbox, missing_from_sandbox, with_links
from jobs.process.stage_environment import has_secrets

__all__ = ["enter_stage_sandbox", "missing_from_stages"]

_GPUS = tuple(map(Path, ("/dev/nvidiactl", "/dev/nvidia0", "/dev/dxg", "/dev/kfd")))


def enter_stage_sandbox(home: Home, stage: str, run: Path) -> None:
    """Refuse this process all files but those of its stage, and TCP; nothing where the stage has secrets, or by a GPU.

    Raises:
        RuntimeError: there are other threads already.
        OSError: the kernel does not take the rules.
    """
    if _has_gpu() or has_secrets(home, stage, run):
        return
    readable = [place for given in _given_to(run) for place in with_links(given)]
    enter_sandbox(readable, (run, Path(tempfile.gettempdir())))


def missing_from_stages() -> str:
    """Return in one line the gaps in the sandbox of this machine's stages; "" if there are none."""
    if _has_gpu():
        return "stages of jobs run without a sandbox: this machine has a GPU, whose drivers open files of their own"
    return missing_from_sandbox()


def _has_gpu() -> bool:
    return any(device.exists() for device in _GPUS)


def _given_to(run: Path) -> tuple[Path, ...]:
    """Return the paths outside a run's folder that its run.json names; of a damaged one none, as the stage will say."""
    try:
        spec = json.loads((run / "run.json").read_bytes())
        capture, given = Path(spec["capture"]), GivenFiles.from_json(spec).places
    except (OSError, ValueError, KeyError, TypeError):
        return ()
    return (capture, *given) if capture.is_absolute() else given
