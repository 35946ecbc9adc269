"""Run folders that are being removed: they are moved away in one step first, so that none is ever half there."""

from __future__ import annotations

import shutil

from hgs_core.runs.run_folder import RunFolder
from jobs.home.home import Home

__all__ = ["empty_trash", "throw_away", "trash"]


def trash(home: Home) -> list[str]:
    """Return the jobs with run folders that were moved away and are still on the disk."""
    folder = home.folder / "trash"
    return sorted(path.name for path in folder.iterdir()) if folder.is_dir() else []


def throw_away(home: Home, job_id: str) -> None:
    """Move a run folder to the trash; nothing happens where there is none.

    Raises:
        InputError: a process works on the run.
        OSError: it cannot be moved.
    """
    run = home.run(job_id)
    if not run.is_dir():
        return
    with RunFolder(run).exclusive(on_lost=lambda: None):
        (home.folder / "trash").mkdir(exist_ok=True)
        empty_trash(home, job_id)
        run.rename(home.folder / "trash" / job_id)


def empty_trash(home: Home, job_id: str) -> None:
    """Remove the files of a run folder that was moved away."""
    shutil.rmtree(home.folder / "trash" / job_id, ignore_errors=True)
