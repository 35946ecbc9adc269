from __future__ import annotations

import json
from typing import Any

import httpx
import pytest

from hgs_core.base.errors import InputError
from jobs.records.job import JobState

PROBLEM = "application/problem+json"


def assert_problem(response: httpx.Response, status: int, code: str, *words: str) -> dict[str, Any]:
    assert response.status_code == status, response.text
    assert response.headers["content-type"] == PROBLEM
    problem: dict[str, Any] = response.json()
    assert (problem["type"], problem["status"], problem["code"]) == ("about:blank", status, code)
    assert problem["instance"] == response.request.url.path
    assert "\n" not in problem["detail"]
    for word in words:
        assert word in problem["detail"]
    return problem


def test_submit_answers_201_with_the_job_and_its_location(server: Any) -> None:
    body = {
        "capture": "studio",
        "title": "Studio",
        "preset": "preview",
        "hold_out": ["cam00"],
        "config": {"train.iterations": 7},
    }
    response = server.request("POST", "/v1/jobs", json=body)
    assert response.status_code == 201
    assert response.headers["location"] == "jobs/job-0"
    job = response.json()
    assert job == server.get("/v1/jobs/job-0").json()
    assert (job["state"], job["preset"], job["hold_out"]) == ("queued", "preview", ["cam00"])
    assert (job["stage"], job["progress"], job["error"], job["scene"]) == (None, None, None, None)
    (request,) = server.jobs.requests
    assert request.capture == server.captures.resolve() / "studio"
    assert (request.title, request.config.train.iterations) == ("Studio", 7)


def test_submit_needs_the_capture_alone(server: Any) -> None:
    response = server.request("POST", "/v1/jobs", json={"capture": str(server.captures / "studio")})
    assert response.status_code == 201
    assert response.json()["preset"] == "standard"


@pytest.mark.parametrize(
    ("body", "field"),
    [
        ({}, "capture"),
        ({"capture": 3}, "capture"),
        ({"capture": ""}, "capture"),
        ({"capture": "studio", "colour": "red"}, "colour"),
        ({"capture": "studio", "hold_out": "cam00"}, "hold_out"),
        ({"capture": "studio", "hold_out": [0]}, "hold_out.0"),
        ({"capture": "studio", "config": []}, "config"),
        ({"capture": "studio", "labels": "night"}, "labels"),
        ({"capture": "studio", "labels": ["two words"]}, "labels"),
        ({"capture": "studio", "audio": ""}, "audio"),
        ({"capture": "studio", "audio": ["none"]}, "audio"),
        ({"capture": "studio", "audio": "gone.wav"}, "audio"),
        ({"capture": "studio", "priority": 101}, "priority"),
        ({"capture": "studio", "priority": 1.5}, "priority"),
        ({"capture": "studio", "time_limit": -1}, "time_limit"),
        ({"capture": "studio", "webhook": "http://127.0.0.1/"}, "webhook"),
    ],
)
def test_bad_fields_are_422_and_named(server: Any, body: dict[str, Any], field: str) -> None:
    problem = assert_problem(server.request("POST", "/v1/jobs", json=body), 422, "body-invalid", field)
    assert problem["field"] == field
    assert not server.jobs.jobs


@pytest.mark.parametrize(
    ("body", "field"),
    [
        ({"preset": "perfect"}, "preset"),
        ({"config": {"train.iterations": 0}}, "config.train.iterations"),
        ({"config": {"train": {"iterations": 0}}}, "config.train.iterations"),
        ({"config": {"train.iterations": 5, "train": {"iterations": 5}}}, "config.train"),
        ({"config": {"cycels": 9}}, "config.cycels"),
        ({"config": {"train.learning_rates": {"opacity": "big"}}}, "config.train.learning_rates.opacity"),
        ({"config": {"capture.hold_out": ["cam00"]}}, "config.capture.hold_out"),
        ({"config": {"capture": {"hold_out": ["cam00"]}}}, "config.capture.hold_out"),
        ({"config": {"preset": "best"}}, "config.preset"),
        ({"hold_out": ["a", "a"]}, "hold_out"),
    ],
)
def test_bad_configs_are_422_and_named(server: Any, body: dict[str, Any], field: str) -> None:
    problem = assert_problem(
        server.request("POST", "/v1/jobs", json={"capture": "studio", **body}), 422, "config-invalid"
    )
    assert problem["field"] == field


def test_the_sound_of_a_job_is_a_choice_or_a_file_that_the_server_may_read(server: Any) -> None:
    file = server.captures.resolve() / "studio" / "recorder.wav"
    file.write_bytes(b"")
    told = [
        server.request("POST", "/v1/jobs", json={"capture": "studio", "audio": audio}).json()["audio"]
        for audio in ("auto", "none", "camera:cam01", "recorder.wav", str(file))
    ]
    asked = [request.given.audio for request in server.jobs.requests]
    assert told == asked == ["auto", "none", "camera:cam01", str(file), str(file)]
    response = server.request("POST", "/v1/jobs", json={"capture": "studio", "audio": "/etc/hostname"})
    assert assert_problem(response, 403, "capture-outside", "HGS_CAPTURES")["field"] == "audio"
    server.jobs.refuse = InputError("--audio camera:cam09", "there is no such camera", field="audio")
    response = server.request("POST", "/v1/jobs", json={"capture": "studio", "audio": "camera:cam09"})
    problem = assert_problem(response, 422, "body-invalid", "audio camera:cam09: there is no such camera")
    assert problem["field"] == "audio"


def test_captures_outside_the_folders_are_403(server: Any) -> None:
    assert_problem(server.request("POST", "/v1/jobs", json={"capture": "/etc"}), 403, "capture-outside")


def test_captures_that_are_not_there_are_422(server: Any) -> None:
    assert_problem(server.request("POST", "/v1/jobs", json={"capture": "missing"}), 422, "capture-invalid", "missing")


def test_captures_that_cannot_be_read_are_422(server: Any) -> None:
    server.jobs.refuse = InputError("cam03.mp4", "59 frames, the others have 60", "record it again")
    response = server.request("POST", "/v1/jobs", json={"capture": "studio"})
    problem = assert_problem(
        response, 422, "capture-invalid", "cam03.mp4: 59 frames, the others have 60; record it again"
    )
    assert problem["field"] == "capture"


def test_hold_out_that_the_capture_lacks_is_a_bad_config(server: Any) -> None:
    server.jobs.refuse = InputError.of_field("config.capture.hold_out", "no camera 99")
    problem = assert_problem(server.request("POST", "/v1/jobs", json={"capture": "studio"}), 422, "config-invalid")
    assert problem["field"] == "hold_out"


def test_pages_of_other_origins_may_not_submit(server: Any) -> None:
    headers = {"Origin": "https://elsewhere.example"}
    response = server.request("POST", "/v1/jobs", json={"capture": "studio"}, headers=headers)
    assert_problem(response, 403, "origin-not-allowed", "elsewhere.example")
    assert not server.jobs.jobs


def submit(server: Any) -> str:
    job_id: str = server.request("POST", "/v1/jobs", json={"capture": "studio"}).json()["id"]
    return job_id


def test_jobs_are_listed_newest_first(server: Any) -> None:
    first, second = submit(server), submit(server)
    assert [job["id"] for job in server.get("/v1/jobs").json()["jobs"]] == [second, first]


def test_a_list_can_be_asked_for_one_state(server: Any) -> None:
    first, second = submit(server), submit(server)
    server.jobs.change(first, state=JobState.RUNNING)
    assert [job["id"] for job in server.get("/v1/jobs?state=running").json()["jobs"]] == [first]
    assert [job["id"] for job in server.get("/v1/jobs?state=queued").json()["jobs"]] == [second]


def test_queries_that_are_not_understood_are_422(server: Any) -> None:
    problem = assert_problem(server.get("/v1/jobs?state=done"), 422, "query-invalid", "state")
    assert problem["field"] == "state"


def test_job_that_waits_says_why(server: Any) -> None:
    server.request("POST", "/v1/jobs", json={"capture": "studio"})
    assert server.get("/v1/jobs/job-0").json()["waiting"] is None
    server.jobs.change("job-0", waiting="the store fails: no answer")
    job = server.get("/v1/jobs/job-0").json()
    assert (job["state"], job["waiting"]) == ("queued", "the store fails: no answer")


def test_running_job_tells_its_progress(server: Any) -> None:
    job_id = submit(server)
    server.jobs.change(job_id, state=JobState.RUNNING, stage="train", done=3, total=9, figures={"loss": 0.5})
    job = server.get(f"/v1/jobs/{job_id}").json()
    assert job["progress"] == {"stage": "train", "done": 3, "total": 9, "figures": {"loss": 0.5}}


@pytest.mark.parametrize(
    ("method", "suffix"), [("GET", ""), ("GET", "/events"), ("POST", "/cancel"), ("POST", "/retry")]
)
def test_unknown_jobs_are_404(server: Any, method: str, suffix: str) -> None:
    assert_problem(server.request(method, f"/v1/jobs/nobody{suffix}"), 404, "job-not-found", "nobody")


def test_cancel_answers_202_and_may_be_repeated(server: Any) -> None:
    job_id = submit(server)
    for _ in range(2):
        response = server.request("POST", f"/v1/jobs/{job_id}/cancel")
        assert (response.status_code, response.json()["state"]) == (202, "cancelled")


@pytest.mark.parametrize("state", [JobState.SUCCEEDED, JobState.FAILED])
def test_finished_jobs_cannot_be_cancelled(server: Any, state: JobState) -> None:
    job_id = submit(server)
    server.jobs.change(job_id, state=state)
    assert_problem(server.request("POST", f"/v1/jobs/{job_id}/cancel"), 409, "job-finished", state.value)


def test_retry_queues_a_failed_job_again(server: Any) -> None:
    job_id = submit(server)
    server.jobs.change(job_id, state=JobState.FAILED, error="out of memory")
    response = server.request("POST", f"/v1/jobs/{job_id}/retry")
    assert response.status_code == 202
    assert (response.json()["state"], response.json()["attempt"]) == ("queued", 2)


def test_retry_of_a_queued_job_is_409(server: Any) -> None:
    assert_problem(server.request("POST", f"/v1/jobs/{submit(server)}/retry"), 409, "job-not-retriable")


def test_events_of_a_finished_job_are_one_event(server: Any) -> None:
    job_id = submit(server)
    server.jobs.change(job_id, state=JobState.SUCCEEDED, scene_id=job_id)
    response = server.get(f"/v1/jobs/{job_id}/events")
    assert response.headers["content-type"].startswith("text/event-stream")
    event, name, data, *rest = response.text.split("\n")
    assert (event, rest) == ("event: job", ["", ""])
    assert name.startswith("id: ")
    assert json.loads(data.removeprefix("data: ")) == server.get(f"/v1/jobs/{job_id}").json()


def test_events_that_the_client_has_seen_to_the_end_are_204(server: Any) -> None:
    job_id = submit(server)
    server.jobs.change(job_id, state=JobState.FAILED, error="no")
    seen = server.get(f"/v1/jobs/{job_id}/events").text.split("\n")[1].removeprefix("id: ")
    assert server.get(f"/v1/jobs/{job_id}/events", Last_Event_ID=seen).status_code == 204


@pytest.mark.parametrize("job_id", ["%00", "A", "-a", "a" * 65, "%ed%a0%80", "a%20b"])
def test_what_is_no_job_id_is_not_looked_up(server: Any, job_id: str) -> None:
    server.jobs.refuse = RuntimeError("a database that cannot store this text")
    for method, path in (("GET", ""), ("GET", "/events"), ("POST", "/cancel"), ("POST", "/retry")):
        response = server.request(method, f"/v1/jobs/{job_id}{path}")
        assert (response.status_code, response.json()["code"]) == (404, "job-not-found")


def test_labels_priority_and_time_limit_are_in_the_job(server: Any) -> None:
    body = {"capture": "studio", "labels": ["night", "acme"], "priority": 5, "time_limit": 3600}
    job = server.request("POST", "/v1/jobs", json=body).json()
    assert (job["labels"], job["priority"], job["time_limit"]) == (["night", "acme"], 5, 3600)
    plain = server.request("POST", "/v1/jobs", json={"capture": "studio"}).json()
    assert (plain["labels"], plain["priority"], plain["time_limit"]) == ([], 0, None)


def test_the_end_of_the_stage_is_told_while_the_job_runs(server: Any) -> None:
    server.request("POST", "/v1/jobs", json={"capture": "studio"})
    server.jobs.change("job-0", state=JobState.RUNNING, stage="train", ends=99.0)
    assert server.get("/v1/jobs/job-0").json()["ends"] == 99.0
    server.jobs.change("job-0", state=JobState.CANCELLED)
    assert server.get("/v1/jobs/job-0").json()["ends"] is None


def test_the_idempotency_key_is_part_of_the_request(server: Any) -> None:
    server.request("POST", "/v1/jobs", json={"capture": "studio"}, headers={"Idempotency-Key": "k-1"})
    assert [request.key for request in server.jobs.requests] == ["k-1"]


def test_a_malformed_key_is_refused(server: Any) -> None:
    bad = server.request("POST", "/v1/jobs", json={"capture": "studio"}, headers={"Idempotency-Key": "a b"})
    assert assert_problem(bad, 422, "body-invalid")["field"] == "Idempotency-Key"


def test_jobs_are_listed_by_label(server: Any) -> None:
    for labels in (["a"], ["a", "b"], []):
        server.request("POST", "/v1/jobs", json={"capture": "studio", "labels": labels})
    assert [job["id"] for job in server.get("/v1/jobs?label=a&label=b").json()["jobs"]] == ["job-1"]


def test_a_finished_job_is_deleted_and_its_scene_stays(server: Any) -> None:
    server.request("POST", "/v1/jobs", json={"capture": "studio"})
    assert_problem(server.request("DELETE", "/v1/jobs/job-0"), 409, "job-not-finished")
    server.jobs.change("job-0", state=JobState.SUCCEEDED, scene_id="job-0")
    server.artifacts.manifests["job-0"] = b"{}"
    assert server.request("DELETE", "/v1/jobs/job-0").status_code == 204
    assert_problem(server.get("/v1/jobs/job-0"), 404, "job-not-found")
    assert server.artifacts.manifest("job-0") == b"{}"


def test_a_page_of_another_site_deletes_nothing(server: Any) -> None:
    response = server.request("DELETE", "/v1/jobs/job-0", headers={"Origin": "https://evil.example"})
    assert_problem(response, 403, "origin-not-allowed")
