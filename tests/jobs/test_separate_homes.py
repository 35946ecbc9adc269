"""Machines that share Postgres and an object store, and no folder: each has a home of its own."""

from __future__ import annotations

import dataclasses
import json
import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import obstore
import pytest
from chain_pipeline import chain
from flaky_proxy import FlakyProxy
from postgres_server import PostgresServer
from s3_server import S3Server, running_s3_server

from hgs_core.base.errors import InputError
from hgs_core.runs.run_config import RunConfig
from hgs_core.runs.stages import train_scene
from jobs.artifacts.artifact_store import ArtifactStore
from jobs.home.home import Home
from jobs.home.home_identity import FILE
from jobs.home.object_store import open_object_store
from jobs.housekeeping import tidy
from jobs.queue.client import JobClient
from jobs.queue.job_request import JobRequest
from jobs.records.job import Job, JobState
from jobs.runs.retention import Retention
from jobs.runs.run_reading import run_reader
from jobs.runs.run_transfer import run_prefix
from jobs.runs.stored_captures import StoredCaptures
from jobs.runs.stored_run import StoredRun
from tests.synthetic import write_capture

Worker = subprocess.Popen[bytes]
Poll = Callable[[Callable[[], bool], str], None]
WaitFor = Callable[[str, Callable[[Job], bool], str], Job]

# The grace of half a minute, after which a worker counts as dead, is not what is tested here.
IMPATIENT = (
    "from jobs import worker; from jobs.queue import liveness; "
    "liveness.PostgresLiveness.__init__.__kwdefaults__.update(grace=1.0)"
)


@pytest.fixture(scope="module")
def s3() -> Iterator[S3Server]:
    with running_s3_server() as server:
        yield server


@pytest.fixture
def pipeline() -> str:
    return "chain_pipeline"


@pytest.fixture
def home(tmp_path: Path, pipeline: str, s3: S3Server, server: PostgresServer, monkeypatch: pytest.MonkeyPatch) -> Home:
    """That of the machine which submits; it runs no worker."""
    for name, value in s3.settings.items():
        monkeypatch.setenv(name, value)
    return dataclasses.replace(
        Home.at(tmp_path / "api"),
        pipeline=pipeline,
        database_url=server.new_database(),
        store_url=f"s3://bucket/{tmp_path.name}",
        run_state="store",
    )


@pytest.fixture
def node(home: Home, tmp_path: Path) -> Iterator[Callable[[str], Worker]]:
    """Return a function that starts a worker on the machine of that name."""
    processes: list[Worker] = []

    def start(name: str) -> Worker:
        environment = {**os.environ, **dataclasses.replace(home, folder=tmp_path / name).environment()}
        command = [sys.executable, "-c", f"{IMPATIENT}; worker.main()"]
        processes.append(subprocess.Popen(command, stdin=subprocess.DEVNULL, env=environment))
        return processes[-1]

    yield start
    for process in processes:
        process.kill()
        process.wait()


def stored(home: Home, prefix: str) -> set[str]:
    pages = obstore.list(open_object_store(home.store_url), prefix=prefix)
    return {item["path"] for page in pages for item in page}


@pytest.mark.parametrize("end", [signal.SIGKILL, pytest.param(signal.SIGTERM, marks=pytest.mark.slow)])
@pytest.mark.slow
def test_another_machine_goes_on_from_the_checkpoint_to_the_same_bits(
    end: signal.Signals,
    client: JobClient,
    submit: Callable[..., str],
    node: Callable[[str], Worker],
    wait_for: WaitFor,
    wait_until: Poll,
    tmp_path: Path,
) -> None:
    first = node("one")
    job_id = submit(iterations=150)
    assert not client.home.run(job_id).exists()
    run = StoredRun(open_object_store(client.home.store_url), run_prefix(job_id))
    wait_until(lambda: (head := run.head()) is not None and "checkpoint.pt" in head.files, "a checkpoint in the store")
    first.send_signal(end)
    first.wait()
    node("two")
    job = wait_for(job_id, lambda job: job.state.finished, "the end of the job")
    assert (job.state, job.error) == (JobState.SUCCEEDED, "")
    store = ArtifactStore(client.home.store_url)
    (chunk,) = store.list_chunks()
    assert store.chunk(chunk.id) == chain(150)

    trained = [line.split() for line in (tmp_path / "capture" / f"{job_id}.log").read_text().splitlines()]
    began = {pid: int(number) for pid, number in reversed(trained)}  # the first iteration of each process
    assert sorted(began.values()) == [0, max(began.values())]
    if end == signal.SIGKILL:
        assert max(began.values()) in range(5, 150, 5), "it did not go on from a checkpoint of the other machine"
    else:  # it saves everything, and only then ends
        assert [int(number) for _, number in trained] == list(range(150))

    log = (run_reader(client.home).folder(job_id) / "stage.log").read_text()
    assert log.count("train begins") == 2
    assert "publish is complete" in log

    assert len(stored(client.home, "runs")) < 7, "checkpoints and points of a finished job are still there"
    client.delete(job_id)
    assert stored(client.home, "runs") == set()


def test_an_upload_is_trained_by_a_machine_that_did_not_take_it(
    client: JobClient, node: Callable[[str], Worker], wait_for: WaitFor, tmp_path: Path
) -> None:
    capture = client.home.folder / "uploads" / "captures" / "studio"
    capture.mkdir(parents=True)
    (capture / "cam00.mp4").write_bytes(b"a video")
    StoredCaptures(client.home).put("studio", capture)
    job_id = client.submit(JobRequest(capture, RunConfig().changed({"train.iterations": 5})))
    shutil.rmtree(capture)
    node("one")
    job = wait_for(job_id, lambda job: job.state.finished, "the end of the job")
    assert (job.state, job.error) == (JobState.SUCCEEDED, "")
    assert (tmp_path / "one" / "fetched" / "studio" / "cam00.mp4").read_bytes() == b"a video"


@pytest.mark.slow
def test_a_store_that_is_away_for_a_while_costs_no_training(
    client: JobClient,
    submit: Callable[..., str],
    home: Home,
    s3: S3Server,
    wait_for: WaitFor,
    wait_until: Poll,
    node: Callable[[str], Worker],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
) -> None:
    job_id = submit(iterations=500)
    proxy = FlakyProxy(int(s3.address.rpartition(":")[2]))
    monkeypatch.setenv("AWS_ENDPOINT", proxy.address)
    node("one")
    monkeypatch.setenv("AWS_ENDPOINT", s3.address)
    run = StoredRun(open_object_store(home.store_url), run_prefix(job_id))
    wait_until(lambda: (head := run.head()) is not None and "checkpoint.pt" in head.files, "a checkpoint in the store")
    proxy.refuse()
    job = wait_for(job_id, lambda job: job.state is JobState.WAITING, "the end of the training")  # the job waits for it
    assert "the store fails" in job.waiting
    proxy.pass_on()
    job = wait_for(job_id, lambda job: job.state.finished, "the end of the job")
    assert (job.state, job.error) == (JobState.SUCCEEDED, "")
    trained = (tmp_path / "capture" / f"{job_id}.log").read_text().splitlines()
    assert [int(line.split()[1]) for line in trained] == list(range(500))
    proxy.refuse()


@pytest.mark.slow
@pytest.mark.parametrize("pipeline", ["segment_pipeline"])
def test_machines_share_the_segments_of_a_job(
    client: JobClient, node: Callable[[str], Worker], wait_for: WaitFor, tmp_path: Path
) -> None:
    capture = tmp_path / "capture"
    capture.mkdir()
    (capture / "segments").write_text("5")
    (capture / "pace").write_text("0.2")
    node("one"), node("two")
    job_id = client.submit(JobRequest(capture, RunConfig().changed({"train.iterations": 8})))
    job = wait_for(job_id, lambda job: job.state.finished, "the end of the job")
    assert (job.state, job.error) == (JobState.SUCCEEDED, "")
    (log,) = tmp_path.glob(f"*/runs/{job_id}/made.log")  # log of the job's machine
    made = log.read_text().split()
    assert made[0] == "0"
    assert 1 < len(made) < 5
    manifest = ArtifactStore(client.home.store_url).manifest(job_id)
    assert manifest is not None
    assert len(json.loads(manifest)["segments"]) == 5
    assert not any("/parts/" in path for path in stored(client.home, "runs"))
    assert not list(tmp_path.glob("*/helped/*"))


@pytest.mark.slow
@pytest.mark.parametrize("pipeline", ["segment_pipeline"])
def test_a_machine_that_dies_with_a_segmented_job_leaves_its_segments_to_the_other(
    client: JobClient, node: Callable[[str], Worker], wait_for: WaitFor, wait_until: Poll, tmp_path: Path
) -> None:
    capture = tmp_path / "capture"
    capture.mkdir()
    (capture / "segments").write_text("4")
    (capture / "pace").write_text("0.2")
    workers = {name: node(name) for name in ("one", "two")}
    job_id = client.submit(JobRequest(capture, RunConfig().changed({"train.iterations": 40})))
    wait_until(lambda: len([path for path in stored(client.home, "runs") if "/parts/" in path]) >= 4, "two segments")
    (owner,) = (name for name in workers if (tmp_path / name / "runs" / job_id).exists())
    workers[owner].kill()
    job = wait_for(job_id, lambda job: job.state.finished, "the end of the job")
    assert (job.state, job.error) == (JobState.SUCCEEDED, "")
    manifest = ArtifactStore(client.home.store_url).manifest(job_id)
    assert manifest is not None
    assert len(json.loads(manifest)["segments"]) == 4


@pytest.mark.slow
@pytest.mark.parametrize("pipeline", ["hgs_core.runs.stages"])
@pytest.mark.parametrize("by_segment", [False, True])
def test_the_trainer_makes_the_same_bits_on_two_machines_as_on_one(
    client: JobClient,
    node: Callable[[str], Worker],
    wait_for: WaitFor,
    wait_until: Poll,
    tmp_path: Path,
    by_segment: bool,
) -> None:
    write_capture(tmp_path / "capture")
    config = RunConfig.from_json(
        {
            "capture": {"hold_out": ["2"]},
            "points": {"static": 200, "dynamic": 40, "interval": 0.1},
            "train": {"iterations": 200, "checkpoint_every": 10, "segment_frames": 2},
            "encode": {"by_segment": by_segment},
        }
    )
    first = node("one")
    job_id = client.submit(JobRequest(tmp_path / "capture", config))
    run = StoredRun(open_object_store(client.home.store_url), run_prefix(job_id))
    if by_segment:
        node("two")  # helps
    else:
        wait_until(lambda: (head := run.head()) is not None and "checkpoint.pt" in head.files, "a checkpoint")
        first.kill()
        node("two")
    job = wait_for(job_id, lambda job: job.state.finished, "the end of the job")
    assert job.state is JobState.SUCCEEDED, job.error
    alone = train_scene(tmp_path / "capture", tmp_path / "alone", config)
    text = ArtifactStore(client.home.store_url).manifest(job_id)
    assert text is not None
    manifests = [json.loads(text), json.loads((alone / "scene" / "manifest.json").read_text())]
    for manifest in manifests:
        del manifest["training"]["seconds"]
    assert manifests[0] == manifests[1]


def test_runs_of_no_job_are_tidied_away(client: JobClient, submit: Callable[..., str]) -> None:
    job_id = submit()
    size = sum(len(path) > 0 for path in stored(client.home, "runs"))
    assert size == 2  # run.json and the head
    assert tidy(client, Retention(), delete=True).job_bytes == 0  # it is young, and of a job
    assert len(stored(client.home, "runs")) == 2
    client.cancel(job_id)
    tidied = tidy(client, Retention(jobs=0), delete=True)
    assert tidied.jobs == (job_id,)
    assert tidied.job_bytes > 0
    assert stored(client.home, "runs") == set()


def test_a_machine_with_another_store_is_refused(client: JobClient, home: Home, tmp_path: Path) -> None:
    other = dataclasses.replace(home, folder=tmp_path / "other", store_url=f"{home.store_url}/elsewhere")
    with pytest.raises(InputError, match=f"{other.store_url}: has no home-id"):
        JobClient(other)
    obstore.put(open_object_store(other.store_url), FILE, b"another")
    with pytest.raises(InputError, match="is the store of another database"):
        JobClient(other)
    JobClient(dataclasses.replace(home, folder=tmp_path / "other")).close()


def test_a_machine_that_looks_for_runs_in_its_home_is_refused(client: JobClient, home: Home, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="is not the home of this database"):
        JobClient(dataclasses.replace(home, folder=tmp_path / "other", run_state="home"))
