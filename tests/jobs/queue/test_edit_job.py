from __future__ import annotations

from pathlib import Path

import pytest

from hgs_core.codec import load_manifest
from hgs_core.runs.run_folder import RunFolder
from jobs.artifacts.artifact_store import open_store
from jobs.home.home import Home
from jobs.queue.edit_job import make_edit_job
from jobs.queue.edit_request import EditRequest


def test_the_run_of_an_edit_has_a_copy_of_the_scene(home: Home, scene: Path) -> None:
    store = open_store(home)
    store.put_scene(scene, "studio")
    store.rename_scene("studio", "The studio")
    job = make_edit_job(home, EditRequest("studio", b"a list"))
    assert (job.title, job.id.rpartition("-")[0]) == ("The studio", "the-studio")
    run = home.run(job.id)
    assert job.capture == str(run / "source" / "studio")
    assert load_manifest(Path(job.capture)).title == "The studio"
    assert (run / "edit.json").read_bytes() == b"a list"
    assert RunFolder(run).read_spec().edited
    assert make_edit_job(home, EditRequest("studio", b"", title="Clean")).title == "Clean"


def test_a_scene_that_is_being_deleted_leaves_nothing(home: Home, scene: Path) -> None:
    store = open_store(home)
    store.put_scene(scene, "studio")
    store.remove_chunks([load_manifest(scene).static[0].id])
    with pytest.raises(KeyError, match="studio"):
        make_edit_job(home, EditRequest("studio", b""))
    assert not home.runs.exists() or not any(home.runs.iterdir())
