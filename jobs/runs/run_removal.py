"""The copies of runs on a worker's machine, where their state lies in the store: removed once nobody needs them."""

from __future__ import annotations

import contextlib
import shutil
import time
from collections.abc import Callable, Collection, Mapping

from hgs_core.base.errors import InputError
from jobs.home.home import Home
from jobs.records.job import Job
from jobs.runs.run_trash import empty_trash, throw_away, trash
from jobs.runs.stored_segments import help_folder, job_of_folder

__all__ = ["remove_copies"]

YOUNGEST = 3600.0  # seconds: a run of no job that is younger may be that of a job which is just being submitted


def remove_copies(home: Home, many: Callable[[Collection[str]], Mapping[str, Job]]) -> list[str]:
    """Remove the run folders of jobs that are finished or gone, and return their names; `many` finds jobs by their ids.

    A run that a process works on stays.
    """
    removed = []
    folders = {folder.name: folder for folder in home.runs.iterdir() if folder.is_dir()}
    jobs = many(folders)
    for name, folder in folders.items():
        job = jobs.get(name)
        if job is None and time.time() - folder.stat().st_mtime < YOUNGEST:
            continue
        if job is None or job.state.finished:
            with contextlib.suppress(InputError):  # its last process still saves what it has
                throw_away(home, name)
                removed.append(name)
    helped = help_folder(home, "")
    for folder in helped.iterdir() if helped.is_dir() else ():  # left by a killed worker
        if (job := many([job_of_folder(folder)]).get(job_of_folder(folder))) is None or job.state.finished:
            shutil.rmtree(folder, ignore_errors=True)
    for name in trash(home):
        empty_trash(home, name)
    return removed
