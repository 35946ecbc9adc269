"""A job's run folder as the API shows it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from hgs_core.base.progress import Progress
from jobs.records.announcements import Announcement
from jobs.records.job import JobState
from jobs.runs.progress_log import CourseWriter


@pytest.fixture
def run(server: Any) -> Path:
    """The run folder of the job `job-0`."""
    server.request("POST", "/v1/jobs", json={"capture": "studio"})
    folder: Path = server.home.run("job-0")
    (folder / "scene").mkdir(parents=True)
    return folder


@pytest.mark.parametrize("name", ["run", "history", "log", "picture", "report"])
@pytest.mark.parametrize("job_id", ["unknown", "..", "%2e%2e", "A"])
def test_unknown_jobs_are_404(server: Any, job_id: str, name: str) -> None:
    assert server.get(f"/v1/jobs/{job_id}/{name}").status_code == 404


def test_a_new_job_has_nothing_yet(server: Any, run: Path) -> None:
    nothing = {"ahead": 0, "announcement": None, "picture": None, "report": False, "scene": None}
    assert server.get("/v1/jobs/job-0/run").json() == nothing


def test_how_the_announcement_of_the_end_went_is_told(server: Any, run: Path) -> None:
    server.jobs.change("job-0", webhook="https://hooks.example.org/secret")
    assert server.get("/v1/jobs/job-0").json()["webhook"] == "https://hooks.example.org"
    for fields, state in (
        ({"next_try": 9.0, "error": "the receiver answered 500"}, "waiting"),
        ({"delivered": 9.0}, "delivered"),
        ({"error": "the receiver answered 410"}, "given-up"),
    ):
        told = Announcement("job-0", 1, "https://hooks.example.org/secret", "{}", 1.0, 2, **fields)  # type: ignore[arg-type]
        server.jobs.announcements["job-0"] = told
        answer = server.get("/v1/jobs/job-0/run").json()["announcement"]
        assert answer == {"state": state, "attempt": 1, "tries": 2, "error": told.error or None}
    assert server.get("/v1/jobs/job-0/history").json() == {"points": []}
    assert server.get("/v1/jobs/job-0/log").json() == {"lines": [], "complete": True}
    for name in ("picture", "report"):
        answer = server.get(f"/v1/jobs/job-0/{name}")
        assert (answer.status_code, answer.json()["code"]) == (404, f"{name}-not-found")


def test_a_waiting_job_knows_how_many_are_ahead(server: Any, run: Path) -> None:
    server.request("POST", "/v1/jobs", json={"capture": "studio"})
    assert server.get("/v1/jobs/job-1/run").json()["ahead"] == 1
    server.jobs.change("job-1", state=JobState.RUNNING)
    assert server.get("/v1/jobs/job-1/run").json()["ahead"] is None


def test_a_finished_job_names_its_scene_while_that_is_published(server: Any, run: Path, manifest: bytes) -> None:
    server.jobs.change("job-0", state=JobState.SUCCEEDED, scene_id="job-0")
    server.artifacts.manifests["job-0"] = manifest
    assert server.get("/v1/jobs/job-0/run").json()["scene"] == "job-0"
    server.request("DELETE", "/v1/scenes/job-0")
    assert server.get("/v1/jobs/job-0/run").json()["scene"] is None


def test_the_course_of_a_job_is_told(server: Any, run: Path) -> None:
    CourseWriter(run, 1).add(Progress("train", 10, 2000, {"psnr": 20.5}))
    (point,) = server.get("/v1/jobs/job-0/history").json()["points"]
    assert point.pop("time") > 0
    assert point == {"attempt": 1, "stage": "train", "done": 10, "total": 2000, "figures": {"psnr": 20.5}}


def test_a_long_course_is_thinned(server: Any, run: Path) -> None:
    for attempt in range(1, 21):
        writer = CourseWriter(run, attempt)
        for done in range(1, 301):
            writer.add(Progress(f"stage-{attempt}", done, 300))
    assert len(server.get("/v1/jobs/job-0/history").json()["points"]) <= 1100


@pytest.mark.parametrize(
    ("query", "first", "complete"), [("", 50, False), ("?lines=2", 148, False), ("?lines=1000", 0, True)]
)
def test_the_end_of_the_log_is_shown(server: Any, run: Path, query: str, first: int, complete: bool) -> None:
    lines = [f"line {number}" for number in range(150)]
    (run / "stage.log").write_text("\n".join(lines) + "\n")
    assert server.get(f"/v1/jobs/job-0/log{query}").json() == {"lines": lines[first:], "complete": complete}


@pytest.mark.parametrize(
    ("raw", "shown"),
    [
        (b"\x1b[31mred\x1b[0m", "red"),
        (b" 10%\r 20%\r 30%", " 30%"),
        (b"dos\r", "dos"),
        (b"a\x00b\x07c\td", "abc\td"),
        (b"\xff", "\ufffd"),
        (b"x" * 5000, "x" * 2000),
        (b"<script>alert(1)</script>", "<script>alert(1)</script>"),
    ],
)
def test_a_line_of_the_log_is_shown_as_a_terminal_would(server: Any, run: Path, raw: bytes, shown: str) -> None:
    (run / "stage.log").write_bytes(raw + b"\n")
    answer = server.get("/v1/jobs/job-0/log")
    assert answer.json()["lines"] == [shown]
    assert answer.headers["content-type"] == "application/json"


@pytest.mark.parametrize("query", ["lines=0", "lines=1001", "lines=many", "lines=1&lines=1", "rows=1", "lines="])
def test_bad_queries_of_the_log_are_422(server: Any, run: Path, query: str) -> None:
    answer = server.get(f"/v1/jobs/job-0/log?{query}")
    assert (answer.status_code, answer.json()["code"]) == (422, "query-invalid")


def test_a_running_job_names_the_scene_that_grows(server: Any, run: Path, manifest: bytes) -> None:
    server.jobs.change("job-0", state=JobState.RUNNING)
    assert server.get("/v1/jobs/job-0/run").json()["scene"] is None
    server.artifacts.manifests["job-0"] = manifest
    assert server.get("/v1/jobs/job-0/run").json()["scene"] == "job-0"


def test_the_picture_is_that_of_the_training_until_the_scene_has_one(server: Any, run: Path) -> None:
    (run / "preview.jpg").write_bytes(b"preview")
    first = server.get("/v1/jobs/job-0/picture")
    assert (first.content, first.headers["content-type"]) == (b"preview", "image/jpeg")
    assert server.get("/v1/jobs/job-0/picture", If_None_Match=first.headers["etag"]).status_code == 304
    version = server.get("/v1/jobs/job-0/run").json()["picture"]
    (run / "scene" / "thumbnail.jpg").write_bytes(b"thumbnail")
    assert server.get("/v1/jobs/job-0/picture").content == b"thumbnail"
    assert server.get("/v1/jobs/job-0/run").json()["picture"] not in (None, version)


def test_the_report_can_show_itself_and_reach_nothing(server: Any, run: Path) -> None:
    (run / "report.html").write_text("<!doctype html><title>Report</title>")
    assert server.get("/v1/jobs/job-0/run").json()["report"] is True
    answer = server.get("/v1/jobs/job-0/report")
    assert (answer.status_code, answer.headers["content-type"]) == (200, "text/html; charset=utf-8")
    policy = answer.headers["content-security-policy"].split("; ")
    assert "sandbox allow-scripts" in policy  # no allow-same-origin: the page has an origin of its own
    assert {"default-src 'none'", "frame-ancestors 'none'", "form-action 'none'"} <= set(policy)


def test_what_is_too_large_is_not_read(server: Any, run: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("server.routes.job_runs._LARGEST_PICTURE", 3)
    (run / "preview.jpg").write_bytes(b"four")
    assert server.get("/v1/jobs/job-0/picture").status_code == 500
