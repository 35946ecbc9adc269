"""How a worker starts, hears and ends its stages."""

from __future__ import annotations

import asyncio
import dataclasses
import json
import re
from collections.abc import Callable
from pathlib import Path

import pytest

from hgs_core.base.progress import Progress
from hgs_core.runs.run_config import RunConfig
from jobs.artifacts.artifact_store import ArtifactStore
from jobs.home.home import Home
from jobs.home.stage_limits import StageLimits
from jobs.home.stage_settings import StageCount, StageSeconds
from jobs.process import stage_outcome
from jobs.process import stage_runner as subprocesses
from jobs.process.memory_limit import CURE
from jobs.process.stage_outcome import Done, Failed, Killed, StageOutcome, Waits
from jobs.process.stage_runner import OwnershipLost, StageRunner
from jobs.process.stage_silence import LOOKS, Silence


@pytest.fixture
def make_run(tmp_path: Path) -> Callable[..., Path]:
    def make_run(behaviour: str, iterations: int = 100_000) -> Path:
        import counting_pipeline

        (tmp_path / "behaviour").write_text(behaviour)
        counting_pipeline.create_run(tmp_path / "run", tmp_path, RunConfig().changed({"train.iterations": iterations}))
        return tmp_path / "run"

    return make_run


HUNG = Killed("train: hung: nothing was heard of it for too long, and it was killed")


def iterations_of(run: Path) -> list[str]:
    log = run / "iterations.log"
    return log.read_text().splitlines() if log.exists() else []


class Stage:
    """A stage that runs inside a test's event loop."""

    def __init__(self, home: Home, run: Path) -> None:
        self.runner = StageRunner(home)
        self.reports: list[Progress] = []
        self.first_report = asyncio.Event()
        self.task = asyncio.create_task(self.runner.run("workflow", "train", run, self._on_progress))

    async def _on_progress(self, progress: Progress) -> None:
        self.reports.append(progress)
        self.first_report.set()


def test_progress_is_relayed(home: Home, make_run: Callable[..., Path]) -> None:
    async def body() -> None:
        stage = Stage(home, make_run("count", 10))
        assert await stage.task == Done()
        assert stage.reports[0] == Progress("train", 0, 10, {"loss": 1.0})
        assert stage.reports[-1].done == 10
        assert stage.runner.workflows() == []

    asyncio.run(body())


def test_a_failure_has_its_reason_and_its_traceback_in_the_log(home: Home, make_run: Callable[..., Path]) -> None:
    async def body() -> None:
        run = make_run("raise", 10)
        assert await Stage(home, run).task == Failed("RuntimeError: the loss is not a number")
        assert "Traceback" in (run / "stage.log").read_text()

    asyncio.run(body())


@pytest.mark.parametrize(
    ("kills", "said"),
    [
        ([6, 6], "train: ended by SIGKILL from outside; the system did not run out of memory"),
        ([6, 7], f"train: out of memory: the system killed it; {CURE}"),
        ([None, None], "train: ended by SIGKILL (out of memory?)"),
    ],
)
def test_an_outcome_by_signal_says_so(
    home: Home, make_run: Callable[..., Path], monkeypatch: pytest.MonkeyPatch, kills: list[int | None], said: str
) -> None:
    for module in (subprocesses, stage_outcome):
        monkeypatch.setattr(module, "system_kills", lambda: kills.pop(0))

    async def body() -> None:
        assert await Stage(home, make_run("die", 10)).task == Killed(said)

    asyncio.run(body())


def test_a_stage_without_memory_says_so_itself(home: Home, make_run: Callable[..., Path]) -> None:
    async def body() -> None:
        outcome = await Stage(home, make_run("memory", 10)).task
        assert isinstance(outcome, Failed)
        assert outcome.error.startswith("out of memory: Unable to allocate 1.00 EiB for an array")
        assert outcome.error.endswith(CURE)

    asyncio.run(body())


@pytest.mark.parametrize(("behaviour", "saved"), [("count", True), ("deaf", False)])
def test_cancelling_lets_the_stage_save_or_kills_it(
    home: Home,
    make_run: Callable[..., Path],
    monkeypatch: pytest.MonkeyPatch,
    behaviour: str,
    saved: bool,
) -> None:
    monkeypatch.setattr(subprocesses, "GRACE", 30.0 if saved else 0.2)

    async def body() -> None:
        run = make_run(behaviour)
        stage = Stage(home, run)
        await stage.first_report.wait()
        await asyncio.sleep(0.06)
        stage.task.cancel()
        with pytest.raises(asyncio.CancelledError):
            await stage.task
        assert stage.runner.workflows() == []
        iterations = len((run / "iterations.log").read_text().splitlines())
        assert ((run / "checkpoint.pt").exists() and int((run / "checkpoint.pt").read_text()) == iterations) is saved

    asyncio.run(body())


def test_an_abandoned_stage_is_killed_and_reports_the_loss(home: Home, make_run: Callable[..., Path]) -> None:
    async def body() -> None:
        stage = Stage(home, make_run("deaf"))
        await stage.first_report.wait()
        stage.runner.abandon("workflow")
        with pytest.raises(OwnershipLost):
            await stage.task

    asyncio.run(body())


def test_a_stopping_worker_records_no_outcome(home: Home, make_run: Callable[..., Path]) -> None:
    async def body() -> None:
        run = make_run("count")
        stage = Stage(home, run)
        await stage.first_report.wait()
        stage.runner.stop()
        while stage.runner.workflows():
            await asyncio.sleep(0.02)
        assert (run / "checkpoint.pt").exists()
        _, pending = await asyncio.wait({stage.task}, timeout=0.1)
        assert pending
        stage.task.cancel()

    asyncio.run(body())


def test_a_stage_that_hangs_is_killed(home: Home, make_run: Callable[..., Path]) -> None:
    async def body() -> None:
        impatient = dataclasses.replace(home, limits=StageLimits(silence=StageSeconds(1000.0, (("train", 5.0),))))
        assert await Stage(impatient, make_run("hang once", 10)).task == HUNG

    asyncio.run(body())


def test_a_stage_that_computes_for_ever_is_killed(home: Home, make_run: Callable[..., Path]) -> None:
    async def body() -> None:
        impatient = dataclasses.replace(home, limits=StageLimits(StageSeconds(10.0), StageSeconds(5.0)))
        assert await Stage(impatient, make_run("compute", 10)).task == HUNG

    asyncio.run(body())


@pytest.mark.slow
def test_a_stage_that_computes_without_a_word_is_not(
    home: Home, make_run: Callable[..., Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    looks: list[Silence] = []
    look = Silence.look

    def counted(silence: Silence) -> None:
        looks.append(silence)
        look(silence)

    monkeypatch.setattr(Silence, "look", counted)

    async def body() -> None:
        run = make_run("compute", 10)
        stage = Stage(dataclasses.replace(home, limits=StageLimits(StageSeconds(5.0))), run)
        while len(iterations_of(run)) < 6:
            await asyncio.sleep(0.05)
        looks.clear()
        while len(looks) <= 2 * LOOKS:
            await asyncio.sleep(0.05)
        (run / "enough").touch()
        assert await stage.task == Done()

    asyncio.run(body())


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="the system has no /proc")
class TestProcesses:
    def test_a_stage_that_starts_ever_more_is_ended_alone_with_all_of_them(
        self, home: Home, make_run: Callable[..., Path], tmp_path: Path
    ) -> None:
        from counting_pipeline import living_sleepers

        async def body() -> None:
            other = make_run("compute", 10).rename(tmp_path / "other")
            beside = Stage(home, other)
            await beside.first_report.wait()
            run = make_run("fork", 10)
            outcome = await Stage(home, run).task
            assert isinstance(outcome, Failed)  # or it would be started again
            assert re.fullmatch(
                r"train: too many processes: \d+, limit 256; raise HGS_STAGE_PROCESSES if they are meant", outcome.error
            )
            if (run / "sleepers").exists():  # it may have been ended while it started them
                assert living_sleepers(run) == []
            assert not beside.task.done()
            (other / "enough").touch()
            assert await beside.task == Done()

        asyncio.run(body())

    def test_threads_count_in_proportion(self, home: Home, make_run: Callable[..., Path]) -> None:
        async def body() -> None:
            narrow = dataclasses.replace(home, limits=StageLimits(processes=StageCount(1)))
            outcome = await Stage(narrow, make_run("threads", 10)).task
            assert isinstance(outcome, Failed)
            assert outcome.error.startswith("train: too many threads: ")

        asyncio.run(body())

    def test_what_a_stage_leaves_behind_ends_with_it(self, home: Home, make_run: Callable[..., Path]) -> None:
        from counting_pipeline import living_sleepers

        async def body() -> None:
            run = make_run("leave", 10)
            assert await Stage(home, run).task == Done()
            assert living_sleepers(run) == []

        asyncio.run(body())


class TestSegments:
    """A training by segments, in a process without access to the store."""

    @pytest.fixture
    def home(self, home: Home, tmp_path: Path) -> Home:
        return dataclasses.replace(home, pipeline="segment_pipeline", store_url=(tmp_path / "elsewhere").as_uri())

    def run(self, home: Home, folder: Path) -> StageOutcome:
        async def body() -> StageOutcome:
            folder.mkdir()
            (folder / "run.json").write_text(json.dumps({"segments": 2, "pace": 0, "iterations": 1}))
            return await Stage(home, folder).task

        return asyncio.run(body())

    def test_the_worker_publishes_it(self, home: Home, tmp_path: Path) -> None:
        assert self.run(home, tmp_path / "scene") == Done()
        manifest = ArtifactStore(home.store_url).manifest("scene")
        assert manifest is not None
        assert json.loads(manifest)["live"] == 2

    def test_why_the_worker_could_not_is_the_reason_of_the_stage(self, home: Home, tmp_path: Path) -> None:
        outcome = self.run(home, tmp_path / "NO ID")
        assert isinstance(outcome, Failed)
        assert outcome.error.startswith("scene id: 'NO ID' is not")


def test_a_fault_that_passes_is_told_from_a_failure(home: Home, make_run: Callable[..., Path]) -> None:
    async def body() -> None:
        run = make_run("full once", 10)
        assert await Stage(home, run).task == Waits(f"{run}/checkpoint.pt: No space left on device")

    asyncio.run(body())


def test_a_job_without_a_run_folder_fails(home: Home, tmp_path: Path) -> None:
    async def body() -> None:
        with pytest.raises(FileNotFoundError):
            await Stage(home, tmp_path / "absent").task

    asyncio.run(body())
