from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from jobs.artifacts.artifact_store import open_store
from jobs.housekeeping import tidy
from jobs.queue.client import JobClient
from jobs.runs.retention import Retention
from jobs.runs.run_trash import throw_away, trash


def test_old_jobs_and_unnamed_chunks_go_and_scenes_and_unfinished_jobs_stay(
    client: JobClient, submit: Callable[..., str], write_scene: Callable[..., list[str]], tmp_path: Path
) -> None:
    ids = [submit() for _ in range(4)]
    for job_id in ids[:3]:
        client.cancel(job_id)
    throw_away(client.home, ids[0])  # a killed removal
    (client.home.run(ids[1]) / "checkpoint.pt").write_bytes(b"x" * 1000)
    store = open_store(client.home)
    chunks = write_scene(tmp_path / "scene")
    for scene in (ids[1], "taken-back"):
        store.put_scene(tmp_path / "scene", scene)
    store.remove_scene("taken-back")

    found = tidy(client, Retention(jobs=1), delete=False, youngest=0)
    assert found.jobs == (ids[1], ids[0])
    assert found.job_bytes > 1000
    assert found.chunks.chunks == 0
    assert [client.home.run(job_id).is_dir() for job_id in ids] == [False, True, True, True]

    assert tidy(client, Retention(jobs=1), delete=True, youngest=0) == found
    assert [job.id for job in client.list()] == [ids[3], ids[2]]
    assert sorted(path.name for path in client.home.runs.iterdir()) == sorted(ids[2:])
    assert trash(client.home) == []
    assert [scene.id for scene in store.list_scenes()] == [ids[1]]
    assert {chunk.id for chunk in store.list_chunks()} == set(chunks)


def test_without_a_retention_every_job_stays(client: JobClient, submit: Callable[..., str]) -> None:
    client.cancel(submit())
    assert tidy(client, Retention(), delete=True).jobs == ()
    assert len(client.list()) == 1
