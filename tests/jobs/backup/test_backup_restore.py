"""Homes that are made of backups."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import subprocess
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import pytest
from chain_pipeline import chain

from hgs_core.base.errors import InputError
from hgs_core.runs.run_config import RunConfig
from jobs.artifacts.artifact_store import open_store
from jobs.artifacts.store_check import check_store
from jobs.backup.backup_restore import restore
from jobs.backup.home_backup import back_up
from jobs.home.home import Home
from jobs.queue.client import JobClient
from jobs.queue.job_request import JobRequest
from jobs.records.keys import KeyTable

Poll = Callable[[Callable[[], bool], str], None]
ITERATIONS = 200


@pytest.fixture
def pipeline() -> str:
    return "chain_pipeline"


def files(folder: Path) -> set[str]:
    return {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}


def test_a_home_is_made_of_a_backup_again(used: Home, elsewhere: Home, tmp_path: Path) -> None:
    made = back_up(used, tmp_path / "backup")
    assert made.holes == ()
    restore(tmp_path / "backup", elsewhere)
    kept = {
        "jobs.sqlite",
        "home-id",
        "backup.json",
        "uploads/x-1f9c03ab/upload.json",
        "runs/a/checkpoint.pt",
        "uploads/captures/room/cam 0\n\\.mp4",
    }
    assert kept <= files(elsewhere.folder)
    assert not [name for name in files(elsewhere.folder) if ".tmp" in name or "run.l" in name or "live" in name]
    assert (elsewhere.folder / "uploads/x-1f9c03ab/upload.json").stat().st_mtime == 1e9
    found = check_store(open_store(elsewhere))
    assert (found.scenes, found.chunks, found.sound) == (2, 2, True)
    with closing(KeyTable(used)) as old, closing(KeyTable(elsewhere)) as new:
        assert (new.all(), new.secret()) == (old.all(), old.secret())


def test_a_job_that_was_under_way_goes_on_elsewhere(
    home: Home, elsewhere: Home, worker: Callable[..., subprocess.Popen[bytes]], wait_until: Poll, tmp_path: Path
) -> None:
    capture = home.folder / "captures" / "room"
    capture.mkdir(parents=True)
    (capture / "behaviour").write_text("count")
    with JobClient(home) as client:
        job_id = client.submit(JobRequest(capture, RunConfig().changed({"train.iterations": ITERATIONS})))
        first = worker()
        wait_until(lambda: (home.run(job_id) / "checkpoint.pt").exists(), "the first checkpoint")
        back_up(home, tmp_path / "backup")
        first.kill()
        first.wait()
    home.folder.rename(tmp_path / "gone")
    restore(tmp_path / "backup", elsewhere)
    worker(folder=elsewhere.folder, database_url=elsewhere.database_url, store_url=elsewhere.store_url)
    with JobClient(elsewhere) as client:

        def succeeded() -> bool:
            job = client.get(job_id)
            assert job is not None
            assert not job.error
            return job.state.value == "succeeded"

        wait_until(succeeded, "the end of the job")
        job = client.get(job_id)
        assert job is not None
        assert job.capture == str(elsewhere.folder / "captures" / "room")
    expected = hashlib.sha256(chain(ITERATIONS)).hexdigest()
    assert [chunk.id for chunk in open_store(elsewhere).list_chunks()] == [expected]


@pytest.mark.parametrize("damage", ["changed", "gone", "several"])
def test_a_damaged_backup_is_not_restored(used: Home, elsewhere: Home, tmp_path: Path, damage: str) -> None:
    back_up(used, tmp_path / "backup")
    chunks = sorted((tmp_path / "backup" / "store" / "chunks").iterdir())
    chunks[0].unlink() if damage == "gone" else chunks[0].write_bytes(b"else")
    if damage == "several":
        chunks[1].write_bytes(b"else")
    with pytest.raises(InputError, match="1 others" if damage == "several" else "missing or damaged; nothing"):
        restore(tmp_path / "backup", elsewhere)
    assert not elsewhere.folder.exists()


def test_what_is_there_is_not_written_over(used: Home, tmp_path: Path) -> None:
    back_up(used, tmp_path / "backup")
    before = files(used.folder)
    with pytest.raises(InputError, match=r"is not empty .*; give an HGS_HOME that is not there"):
        restore(tmp_path / "backup", used)
    with pytest.raises(InputError, match="is there already"):
        back_up(used, tmp_path / "backup")
    with pytest.raises(InputError, match="lies in the home"):
        back_up(used, used.folder / "backup")
    assert files(used.folder) == before
    (tmp_path / "mounted").mkdir()  # an empty disk
    restore(tmp_path / "backup", Home.at(tmp_path / "mounted"))


def test_a_restoration_that_was_cut_off_can_be_done_again(used: Home, elsewhere: Home, tmp_path: Path) -> None:
    back_up(used, tmp_path / "backup")
    (elsewhere.folder / ".restoring" / "store").mkdir(parents=True)
    (elsewhere.folder / ".restoring" / "store" / "half").write_text("half")
    restore(tmp_path / "backup", elsewhere)
    assert not (elsewhere.folder / ".restoring").exists()
    assert "store/half" not in files(elsewhere.folder)


@pytest.mark.parametrize("text", [None, "{", "[]", '{"format": 2, "software": "9.9"}', '{"format": 1}'])
def test_what_is_no_backup_is_refused(elsewhere: Home, tmp_path: Path, text: str | None) -> None:
    if text is not None:
        (tmp_path / "backup.json").write_text(text)
    with pytest.raises(InputError, match="backup"):
        restore(tmp_path, elsewhere)


def test_a_list_that_leads_outside_is_refused(used: Home, elsewhere: Home, tmp_path: Path) -> None:
    back_up(used, tmp_path / "backup")
    with (tmp_path / "backup" / "SHA256SUMS").open("a") as sums:
        sums.write(f"{'0' * 64}  ../a/manifest.json\n")
    with pytest.raises(InputError, match="lies outside"):
        restore(tmp_path / "backup", elsewhere)


def test_what_lies_elsewhere_is_named_and_has_to_be_there(used: Home, elsewhere: Home, tmp_path: Path) -> None:
    in_bucket = dataclasses.replace(used, store_url="s3://bucket/hgs")
    made = back_up(in_bucket, tmp_path / "backup")
    assert (made.store, made.database) == ("s3://bucket/hgs", "sqlite")
    assert not (tmp_path / "backup" / "store").exists()
    with pytest.raises(InputError, match="give HGS_STORE_URL=s3://bucket/hgs"):
        restore(tmp_path / "backup", elsewhere)
    restore(tmp_path / "backup", dataclasses.replace(elsewhere, store_url="s3://bucket/hgs"))
    told = json.loads((tmp_path / "backup" / "backup.json").read_text())
    (tmp_path / "backup" / "backup.json").write_text(json.dumps(told | {"database": "postgresql"}))
    with pytest.raises(InputError, match="pg_restore"):
        restore(tmp_path / "backup", dataclasses.replace(Home.at(tmp_path / "third"), store_url="s3://bucket/hgs"))
