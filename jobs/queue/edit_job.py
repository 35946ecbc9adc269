"""The job of an edit, with a run folder that holds a copy of the scene."""

from __future__ import annotations

import shutil

from hgs_core.runs.asked_edit import ask_edit, source_of_edit
from jobs.artifacts.artifact_store import open_store
from jobs.artifacts.scene_copy import copy_scene
from jobs.home.home import Home
from jobs.queue.edit_request import EditRequest
from jobs.queue.job_request import readable_id
from jobs.records.job import Job

__all__ = ["make_edit_job"]


def make_edit_job(home: Home, request: EditRequest) -> Job:
    """Return a job that is in no queue yet, and write its run folder; after an exception nothing stays behind.

    Raises:
        KeyError: there is no such scene.
        InputError: the scene is damaged.
        OSError: the folder cannot be written, for example because the disk is full.
    """
    store = open_store(home)
    entry = store.scene_entry(request.scene)
    described = None if entry is None else store.describe(entry)
    if described is None:
        raise KeyError(request.scene)
    title = request.title.strip() or store.title(request.scene) or described.title or request.scene
    job_id = readable_id(title, "scene")
    run = home.run(job_id)
    source = source_of_edit(run, request.scene)
    try:
        copy_scene(store, request.scene, source, title)
        config = ask_edit(run, request.scene, request.document)
    except BaseException:
        shutil.rmtree(run, ignore_errors=True)
        raise
    return Job(id=job_id, title=title, capture=str(source), config=config.to_json())
