"""A stage by itself, on a database and with a stand-in for its process."""

from __future__ import annotations

import asyncio
import contextlib
import errno
import json
import os
from collections.abc import AsyncIterator, Awaitable, Callable
from pathlib import Path
from typing import cast

import pytest

from hgs_core.base.progress import Progress
from hgs_core.runs.run_folder import RunFolder
from hgs_core.runs.training_need import TrainingNeed
from jobs.home.home import Home
from jobs.home.passing_faults import Cause
from jobs.process.stage_outcome import Done, Failed, Killed, StageOutcome, Waits
from jobs.process.stage_runner import StageRunner
from jobs.queue.stage_attempt import StageAttempt
from jobs.records.job_table import JobTable
from jobs.runs.progress_log import COURSE, read_course
from jobs.runs.readiness import Missing, Surroundings
from jobs.runs.run_saving import RunSaving

EMPTY = "the capture's folder is empty; is it mounted?"

OnProgress = Callable[[Progress], Awaitable[None]]


class FakeStages:
    """Ends every stage with the next of the given outcomes; one that is an exception is raised."""

    def __init__(self) -> None:
        self.outcomes: list[StageOutcome | OSError] = []
        self.reports: list[Progress] = []
        self.on_report: Callable[[], object] = lambda: None
        self.started: list[tuple[str, str, Path]] = []

    async def run(self, workflow: str, stage: str, run: Path, on_progress: OnProgress) -> StageOutcome:
        self.started.append((workflow, stage, run))
        for report in self.reports:
            await on_progress(report)
            self.on_report()
        outcome = self.outcomes.pop(0)
        if isinstance(outcome, OSError):
            raise outcome
        return outcome


@pytest.fixture
def stages() -> FakeStages:
    return FakeStages()


RunStage = Callable[..., StageOutcome]


@pytest.fixture
def run_stage(home: Home, surroundings: Surroundings, table: JobTable, stages: FakeStages) -> RunStage:
    def run_stage(stage: str = "train", saving: object = None) -> StageOutcome:
        attempt = StageAttempt(
            stage,
            "a",
            1,
            home=home,
            surroundings=surroundings,
            table=table,
            stages=cast(StageRunner, stages),
            saving=cast(RunSaving, saving) or RunSaving(home),
            ask_for_help=lambda *arguments: None,
        )
        return asyncio.run(attempt.run())

    return run_stage


class TestStages:
    """The stage's process and its outcome."""

    def test_a_stage_runs_in_the_job_s_folder_and_its_reports_are_kept(
        self, run_stage: RunStage, table: JobTable, stages: FakeStages, home: Home
    ) -> None:
        stages.outcomes = [Done()]
        stages.reports = [Progress("train", 5, 10, {"loss": 0.25})]
        assert run_stage() == Done()
        assert stages.started == [("a:1", "train", home.run("a"))]
        job = table.get("a")
        assert job is not None
        assert (job.stage, job.done, job.total) == ("train", 5, 10)
        assert len(read_course(home.run("a"))) == 1  # not the word that the stage begins

    def test_the_end_of_the_whole_job_is_forecast_from_its_need(
        self, run_stage: RunStage, table: JobTable, stages: FakeStages, home: Home
    ) -> None:
        need = TrainingNeed({"train": 1}, 0, 0, {"points": 100.0, "train": 9000.0, "encode": 1000.0}, (1.0,))
        stages.outcomes = [Done()]
        stages.reports = [Progress("train", 0, 10)]
        need.save(RunFolder(home.run("a")).need)
        run_stage()
        job = table.get("a")
        assert job is not None
        seconds = need.seconds()
        assert job.ends - job.updated == pytest.approx(seconds["train"] + seconds["encode"], abs=60)

    def test_the_pace_of_the_job_s_earlier_stages_corrects_the_forecast(
        self, run_stage: RunStage, table: JobTable, stages: FakeStages, home: Home
    ) -> None:
        need = TrainingNeed({"train": 1}, 0, 0, {"points": 100.0, "train": 9000.0}, (1.0,))
        need.save(RunFolder(home.run("a")).need)
        reports = [{"done": done, "time": 1000.0 + 30 * done} for done in range(11)]  # 300 s for 10 units
        lines = [json.dumps({"attempt": 1, "stage": "points", "total": 10, "figures": {}, **one}) for one in reports]
        (home.run("a") / COURSE).write_text("\n".join(lines) + "\n")
        stages.outcomes, stages.reports = [Done()], [Progress("train", 0, 10)]
        run_stage()
        job = table.get("a")
        assert job is not None
        slower = 310 / (need.seconds()["points"] + 10)
        assert job.ends - job.updated == pytest.approx(slower * need.seconds()["train"], abs=60)

    def test_a_stage_that_a_signal_ended_is_started_three_times(self, run_stage: RunStage, stages: FakeStages) -> None:
        killed = Killed("ended by SIGKILL")
        stages.outcomes = [killed, killed, killed, Done()]
        assert run_stage() == killed
        assert len(stages.started) == 3

    def test_a_stage_that_comes_further_each_time_is_started_again_and_again(
        self, run_stage: RunStage, stages: FakeStages
    ) -> None:
        stages.outcomes = [*[Killed("ended by SIGKILL")] * 8, Done()]
        stages.reports = [Progress("train", 0, 100)]
        stages.on_report = lambda: stages.reports.__setitem__(0, Progress("train", len(stages.started), 100))
        assert run_stage() == Done()
        assert len(stages.started) == 9

    def test_a_stage_that_failed_by_itself_is_not_started_again(self, run_stage: RunStage, stages: FakeStages) -> None:
        stages.outcomes = [Failed("the loss is not a number"), Done()]
        assert run_stage() == Failed("the loss is not a number")
        assert len(stages.started) == 1

    def test_a_full_disk_at_the_start_is_waited_for(self, run_stage: RunStage, stages: FakeStages) -> None:
        stages.outcomes = [OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), "/runs/a/stage.log")]
        assert run_stage() == Waits("/runs/a/stage.log: No space left on device")

    def test_a_stage_does_not_begin_without_its_capture(
        self, run_stage: RunStage, stages: FakeStages, tmp_path: Path
    ) -> None:
        (tmp_path / "capture" / "frame.jpg").unlink()
        assert run_stage("encode") == Waits(f"{tmp_path}/capture: {EMPTY}", Cause.CAPTURE)
        assert stages.started == []

    def test_publication_needs_no_capture(self, run_stage: RunStage, stages: FakeStages, tmp_path: Path) -> None:
        (tmp_path / "capture" / "frame.jpg").unlink()
        stages.outcomes = [Done()]
        assert run_stage("publish") == Done()

    def test_a_failure_is_not_believed_while_the_capture_cannot_be_seen(
        self, run_stage: RunStage, stages: FakeStages, tmp_path: Path
    ) -> None:
        stages.outcomes, stages.reports = [Failed("frame 0 is missing")], [Progress("train", 1, 2)]
        stages.on_report = (tmp_path / "capture" / "frame.jpg").unlink
        assert run_stage() == Waits(f"{tmp_path}/capture: {EMPTY}", Cause.CAPTURE)

    def test_a_store_that_is_seen_to_be_away_is_the_cause(
        self, run_stage: RunStage, stages: FakeStages, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        stages.outcomes = [Waits("the store fails: no route"), Waits("the store fails")]
        assert run_stage("publish") == Waits("the store fails: no route")  # writes alone fail
        monkeypatch.setattr(Surroundings, "store", lambda self: Missing(Cause.STORE, "the store fails: no answer"))
        assert run_stage("publish") == Waits("the store fails", Cause.STORE)

    def test_a_publication_that_is_killed_while_the_store_is_away_waits(
        self, run_stage: RunStage, stages: FakeStages, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setattr(Surroundings, "store", lambda self: Missing(Cause.STORE, "the store fails: no answer"))
        stages.outcomes = [Killed("publish: ended by SIGKILL")] * 3
        assert run_stage("publish") == Waits("the store fails: no answer", Cause.STORE)


class FakeSaving:
    """Where machines share no folder; the store is away at the end of a stage."""

    def __init__(self, capture: Path) -> None:
        self.claims = 0
        self._capture = capture

    def path_of_capture(self, attempt: object) -> Path:
        return self._capture

    def capture(self, job_id: str, submitted: Path) -> Path:
        return submitted

    def taken(self, attempt: object) -> bool:
        return False

    async def claim(self, attempt: object) -> StageOutcome:
        self.claims += 1
        return Done()

    @contextlib.asynccontextmanager
    async def meanwhile(self, attempt: object, on_taken: object) -> AsyncIterator[None]:
        yield

    async def save(self, attempt: object) -> StageOutcome:
        return Waits("the store fails", Cause.STORE)


class TestRunsInTheStore:
    """The job's run is fetched before a stage and saved after it."""

    def test_a_run_whose_capture_is_not_here_is_not_fetched(self, run_stage: RunStage, tmp_path: Path) -> None:
        saving = FakeSaving(tmp_path / "elsewhere")
        outcome = run_stage(saving=saving)
        assert isinstance(outcome, Waits)
        assert outcome.cause is Cause.CAPTURE
        assert saving.claims == 0

    def test_a_stage_whose_results_are_not_saved_is_not_complete(
        self, run_stage: RunStage, stages: FakeStages, tmp_path: Path
    ) -> None:
        stages.outcomes = [Done()]
        assert run_stage(saving=FakeSaving(tmp_path / "capture")) == Waits("the store fails", Cause.STORE)

    def test_but_a_scene_that_is_published_stays_so(
        self, run_stage: RunStage, stages: FakeStages, tmp_path: Path
    ) -> None:
        stages.outcomes = [Done()]
        assert run_stage("publish", FakeSaving(tmp_path / "capture")) == Done()


class TestReports:
    """The reports of a running stage."""

    def test_reports_that_cannot_be_written_do_not_end_the_stage(
        self, run_stage: RunStage, stages: FakeStages, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        def refuse(*arguments: object) -> bool:
            raise OSError(errno.EIO, os.strerror(errno.EIO))

        monkeypatch.setattr(JobTable, "progress", refuse)
        stages.outcomes, stages.reports = [Done()], [Progress("train", 1, 2)]
        assert run_stage() == Done()
