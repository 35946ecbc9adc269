"""The job of a training, with the run folder of its capture."""

from __future__ import annotations

import importlib
import shutil
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from hgs_core.base.storable_text import require_storable
from jobs.home.home import Home
from jobs.queue.job_request import MAX_PATH, MAX_TITLE, JobRequest, one_line, readable_id
from jobs.records.job import Job

if TYPE_CHECKING:
    from hgs_core.runs.given_files import GivenFiles
    from hgs_core.runs.run_config import RunConfig

__all__ = ["CreateRun", "make_training_job"]


class CreateRun(Protocol):
    """The beginning of a run, as in `hgs_core.runs.creation.create_run`."""

    def __call__(self, run: Path, capture: Path, config: RunConfig, given: GivenFiles) -> RunConfig: ...  # noqa: D102


def make_training_job(home: Home, request: JobRequest, create_run: CreateRun | None = None) -> Job:
    """Return a job that is in no queue yet, and write its run folder; after an exception nothing stays behind.

    The run is begun by `create_run`, without one in this process, as the home's pipeline does.

    Raises:
        InputError: the capture, a file beside it or the config is unusable.
        OSError: the folder cannot be written, for example because the disk is full.
    """
    capture = request.capture.expanduser().resolve()
    require_storable("capture", str(capture), MAX_PATH)  # a symbolic link may lead to any name
    title = request.title.strip() or one_line(capture.name)[:MAX_TITLE]
    job_id = readable_id(title, "job")
    create_run = create_run or importlib.import_module(home.pipeline).create_run
    try:
        config = create_run(home.run(job_id), capture, request.config, request.given)
    except BaseException:
        shutil.rmtree(home.run(job_id), ignore_errors=True)
        raise
    return Job(
        id=job_id,
        title=title,
        capture=str(capture),
        config=config.to_json(),
        labels=request.labels,
        priority=request.priority,
        time_limit=request.time_limit,
        webhook=request.webhook,
        audio=request.given.audio,
    )
