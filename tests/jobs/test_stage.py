"""The stage process by itself: its reports and its end."""

from __future__ import annotations

import dataclasses
import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from hgs_core.runs.run_config import RunConfig
from hgs_core.runs.run_folder import RunFolder
from jobs.artifacts.artifact_store import open_store
from jobs.home.home import Home
from jobs.home.stage_limits import StageLimits
from jobs.home.stage_settings import StageBytes
from jobs.queue.edit_job import make_edit_job
from jobs.queue.edit_request import EditRequest
from tests.conftest import REPOSITORY

Stage = subprocess.Popen[bytes]
Poll = Callable[[Callable[[], bool], str], None]


@pytest.fixture
def run(tmp_path: Path) -> Path:
    return make_run(tmp_path, "count")


@pytest.fixture
def start(home: Home) -> Iterator[Callable[[str, Path], Stage]]:
    """Return a function that starts a stage process with pipes on all three standard streams."""
    processes: list[Stage] = []

    def start(stage: str, run: Path) -> Stage:
        pipe = subprocess.PIPE
        process = subprocess.Popen(
            [sys.executable, "-m", "jobs.stage", stage, str(run)],
            stdin=pipe,
            stdout=pipe,
            stderr=pipe,
            env={**os.environ, **home.environment()},
        )
        processes.append(process)
        return process

    yield start
    for process in processes:
        process.kill()
        for stream in (process.stdin, process.stdout, process.stderr):
            assert stream is not None
            stream.close()
        process.wait()


def make_run(folder: Path, behaviour: str, iterations: int = 20) -> Path:
    import counting_pipeline

    (folder / "behaviour").write_text(behaviour)
    counting_pipeline.create_run(folder / "run", folder, RunConfig().changed({"train.iterations": iterations}))
    return folder / "run"


def finish(process: Stage) -> tuple[int, list[dict[str, object]], str]:
    """Wait for the end with stdin open; return the exit status, the messages and stderr."""
    assert process.stdout is not None
    assert process.stderr is not None
    messages = [json.loads(line) for line in process.stdout]
    return process.wait(), messages, process.stderr.read().decode()


def iterations(run: Path) -> list[int]:
    log = run / "iterations.log"
    return [int(line.split()[1]) for line in log.read_text().splitlines()] if log.exists() else []


@pytest.mark.parametrize("pipeline", ["hgs_core.runs.stages"])
def test_a_bad_list_of_splats_fails_the_stage_that_reads_it(
    start: Callable[[str, Path], Stage], home: Home, scene: Path
) -> None:
    open_store(home).put_scene(scene, "studio")
    job = make_edit_job(home, EditRequest("studio", b'{"format": "hgs-splats", "version": 9}'))
    status, messages, _ = finish(start("initialise", home.run(job.id)))
    assert status == 2
    assert str(messages[-1]["error"]).endswith("edit.json: version: is 9, not 1; give a list of splats or a crop")


def test_progress_comes_as_json_lines(start: Callable[[str, Path], Stage], run: Path) -> None:
    status, messages, _ = finish(start("train", run))
    assert status == 0
    assert messages[0] == {"stage": "train", "done": 0, "total": 20, "figures": {"loss": 1.0}}
    assert messages[-1] == {"stage": "train", "done": 20, "total": 20, "figures": {"loss": 0.0}}
    assert len(messages) < 20


def test_what_libraries_print_does_not_mix_with_the_messages(start: Callable[[str, Path], Stage], run: Path) -> None:
    status, messages, errors = finish(start("initialise", run))
    assert status == 0
    assert messages == [{"stage": "initialise", "done": 1, "total": 1, "figures": {}}]
    assert "a library that prints to stdout" in errors


def test_bad_input_is_one_line_and_status_2(start: Callable[[str, Path], Stage], tmp_path: Path) -> None:
    run = make_run(tmp_path, "bad input")
    status, messages, errors = finish(start("train", run))
    assert status == 2
    assert messages[-1] == {"error": f"{run}: frame 3 of camera cam01 is missing; add it"}
    assert "Traceback" not in errors


def test_a_failure_is_one_line_a_traceback_and_status_1(start: Callable[[str, Path], Stage], tmp_path: Path) -> None:
    status, messages, errors = finish(start("train", make_run(tmp_path, "raise")))
    assert status == 1
    assert messages[-1] == {"error": "RuntimeError: the loss is not a number"}
    assert "Traceback" in errors


def test_sigterm_saves_a_checkpoint_and_the_next_process_goes_on_from_there(
    start: Callable[[str, Path], Stage], tmp_path: Path, wait_until: Poll
) -> None:
    run = make_run(tmp_path, "count", iterations=60)
    process = start("train", run)
    wait_until(lambda: len(iterations(run)) >= 3, "three iterations")
    process.send_signal(signal.SIGTERM)
    assert finish(process)[0] == 75
    assert (run / "checkpoint.pt").read_text() == str(len(iterations(run)))
    assert len(iterations(run)) < 60

    assert finish(start("train", run))[0] == 0
    assert iterations(run) == list(range(60))


def test_it_ends_when_its_parent_is_gone(start: Callable[[str, Path], Stage], tmp_path: Path, wait_until: Poll) -> None:
    run = make_run(tmp_path, "count", iterations=100_000)
    process = start("train", run)
    wait_until(lambda: len(iterations(run)) >= 1, "the first iteration")
    assert process.stdin is not None
    process.stdin.close()
    assert process.wait(60) == 70


def test_two_processes_never_work_on_one_run(
    start: Callable[[str, Path], Stage], tmp_path: Path, wait_until: Poll
) -> None:
    run = make_run(tmp_path, "count", iterations=40)
    first = start("train", run)
    wait_until(lambda: len(iterations(run)) >= 1, "the first iteration")
    second = start("train", run)
    assert finish(first)[0] == 0
    assert finish(second)[0] == 0
    assert iterations(run) == list(range(40))


def test_a_run_that_another_process_keeps_is_waited_for(home: Home, run: Path) -> None:
    code = "import sys; from jobs import stage; stage.LOCK_WAIT = 0.1; sys.exit(stage.main())"
    with RunFolder(run).exclusive():
        command = [sys.executable, "-c", code, "train", str(run)]
        environment = {**os.environ, **home.environment()}
        with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=environment) as ended:
            assert ended.stdout is not None
            said = ended.stdout.read()
            assert ended.wait() == 69  # stdin stays open: the stage would end without its parent
    assert json.loads(said) == {"waiting": f"{run}: another process works on this run; wait until it ends"}


def test_a_full_disk_is_waited_for(start: Callable[[str, Path], Stage], tmp_path: Path) -> None:
    run = make_run(tmp_path, "full once")
    status, messages, errors = finish(start("train", run))
    assert status == 69
    assert messages[-1] == {"waiting": f"{run}/checkpoint.pt: No space left on device"}
    assert "Traceback" in errors


def test_too_many_open_files_are_not_waited_for(start: Callable[[str, Path], Stage], tmp_path: Path) -> None:
    status, messages, _ = finish(start("train", make_run(tmp_path, "open")))
    assert status == 1
    line = "too many open files: limit 4096; raise HGS_STAGE_FILES (or ulimit -n) if they are meant"
    assert messages[-1] == {"error": line}


def test_when_its_parent_is_gone_it_leaves_no_process(
    start: Callable[[str, Path], Stage], tmp_path: Path, wait_until: Poll
) -> None:
    from counting_pipeline import living_sleepers

    run = make_run(tmp_path, "fork", iterations=2)
    process = start("train", run)
    wait_until(lambda: (run / "sleepers").exists(), "processes of the stage")
    assert process.stdin is not None
    process.stdin.close()
    assert process.wait(60) == 70
    wait_until(lambda: not living_sleepers(run), "the end of them")


def test_publish_puts_the_scene_under_the_name_of_the_run(
    start: Callable[[str, Path], Stage], home: Home, run: Path
) -> None:
    from jobs.artifacts.artifact_store import ArtifactStore

    for stage in ("initialise", "train", "encode", "publish"):
        assert finish(start(stage, run))[0] == 0
    assert ArtifactStore(home.store_url).manifest("run") == (run / "scene" / "manifest.json").read_bytes()


def test_a_job_that_needs_more_than_a_later_stage_may_take_is_refused_before_any_work(
    home: Home, tmp_path: Path
) -> None:
    from hgs_core.runs.stages import create_run

    create_run(tmp_path / "run", REPOSITORY / "samples" / "studio", RunConfig.for_preset("preview"))
    limits = StageBytes(64e9, (("train", 1e8),))
    home = dataclasses.replace(home, pipeline="hgs_core.runs.stages", limits=StageLimits(memory=limits))
    command = [sys.executable, "-m", "jobs.stage", "initialise", str(tmp_path / "run")]
    environment = {**os.environ, **home.environment(), "HGS_MEMORY_MIB": "65536"}
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=environment) as process:
        assert process.stdout is not None
        (told,) = map(json.loads, process.stdout)
        assert process.wait() == 2
    assert "of memory, and 0.1 GiB are what HGS_STAGE_MEMORY gives to train" in told["error"]
    assert not (tmp_path / "run" / "check.json").exists()
