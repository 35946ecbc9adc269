"""Random histories of uploads, jobs, scenes and restarts: every answer and every list is the one of a model.

The application, its store, its SQLite and its queue are real and in this process. A worker's acts on them are real,
too; the stages that it would start are the pipeline that copies.
"""

from __future__ import annotations

import json
import shutil
import tempfile
from pathlib import Path
from typing import Any, TypeVar

import pytest
from hypothesis import HealthCheck, Phase, settings
from hypothesis import strategies as st
from hypothesis.stateful import (
    RuleBasedStateMachine,
    initialize,
    invariant,
    precondition,
    rule,
    run_state_machine_as_test,
)

from jobs.artifacts.store_check import check_store
from jobs.housekeeping import tidy
from jobs.records.job import JobState
from jobs.runs.retention import Retention
from tests.server.served_home import OPEN_UPLOADS, ServedHome
from tests.server.service_model import Attempt, Model, ModelJob, ModelUpload, captures_in, tus_headers

Found = TypeVar("Found")
PICK = st.integers(0, 11)
OFFSET = {"Tus-Resumable": "1.0.0", "Content-Type": "application/offset+octet-stream"}


def one_of(things: list[Found], pick: int) -> Found:
    return things[pick % len(things)]


class Service(RuleBasedStateMachine):
    """The acts of clients, of a worker and of an operator, in any order."""

    def __init__(self) -> None:
        super().__init__()
        self.folder = Path(tempfile.mkdtemp(prefix="hgs-model-"))
        self.contents = captures_in(self.folder / "sent")
        self.model = Model()
        self.served = ServedHome(self.folder / "home")
        self.requests = 0  # answers of this server

    def ask(self, status: int, method: str, path: str, code: str = "", **arguments: Any) -> Any:
        """Send a request; its answer has this status and this code of a problem."""
        self.requests += 1
        answer = self.served.ask(method, path, **arguments)
        while answer.status_code == 202 and "submissions" in answer.headers.get("location", ""):  # a slow machine
            answer = self.served.ask("GET", f"/v1/submissions/{answer.json()['id']}")
            answer.status_code = 201 if answer.status_code == 200 else answer.status_code
        assert answer.status_code == status, f"{method} {path}: {answer.status_code} {answer.text}"
        if code:
            assert answer.json()["code"] == code, answer.text
        return answer

    @initialize(
        content=st.integers(0, 1),
        acts=st.sampled_from(["", "take", "take publish", "take publish finish", "take publish cancel retry"]),
        half=st.booleans(),
    )
    def have_a_job(self, content: int, acts: str, half: bool) -> None:
        """Begin with a job that has come so far, and half a file: most histories would end before they have them."""
        self.begin_upload("room", "", content)
        self.send_the_rest(0)
        self.finish_upload(0)
        self.submit(0, "a", "")
        for act in acts.split():
            {
                "take": self.take_a_job,
                "publish": self.publish,
                "finish": self.finish_attempt,
                "cancel": self.cancel,
                "retry": self.retry,
            }[act](0)
        if half:
            self.begin_upload("Hall", "", 1 - content)
            self.send_bytes(0, 0, 0.5, "send")

    @rule(name=st.sampled_from(["room", "Hall"]), key=st.sampled_from(["", "k"]), content=st.integers(0, 1))
    def begin_upload(self, name: str, key: str, content: int) -> None:
        wanted = ModelUpload(name, key, self.contents[content])
        unfinished = {one: upload for one, upload in self.model.uploads.items() if not upload.capture}
        known = [one for one, upload in unfinished.items() if upload.announcement == wanted.announcement]
        if not known and len(unfinished) >= OPEN_UPLOADS:
            self.ask(429, "POST", "/v1/uploads", "uploads-open", json=wanted.announcement)
            return
        told = self.ask(200 if known else 201, "POST", "/v1/uploads", json=wanted.announcement).json()
        if known:
            assert told["id"] == known[0]
        else:
            assert told["id"] not in self.model.uploads.keys() | self.model.gone
            self.model.uploads[told["id"]] = wanted

    @precondition(lambda self: self.model.unfinished())
    @rule(pick=PICK, file=PICK, share=st.sampled_from([0.0, 0.5, 1.0]), act=st.sampled_from(["send", "damage", "cut"]))
    def send_bytes(self, pick: int, file: int, share: float, act: str) -> None:
        upload = one_of(self.model.unfinished(), pick)
        path, content = one_of(sorted(upload.files.items()), file)
        place, begin = self.announced(upload, path), upload.received[path]
        data = content[begin : begin + int(share * (len(content) - begin))]
        headers = OFFSET | {"Upload-Offset": str(begin)}
        after = begin + len(data)
        if act == "cut":
            self.served.ask_and_hang_up("PATCH", place, headers, data)
        elif act == "damage" and data and after == len(content):
            self.ask(422, "PATCH", place, "checksum-mismatch", headers=headers, content=bytes(len(data)))
            after = 0
        else:
            answer = self.ask(204, "PATCH", place, headers=headers, content=data)
            assert answer.headers["upload-offset"] == str(after)
        upload.received[path] = after
        told = self.ask(200, "HEAD", place).headers
        assert (told["upload-offset"], told["upload-length"]) == (str(after), str(len(content)))

    def announced(self, upload: ModelUpload, path: str) -> str:
        """Announce a file, perhaps again, and return its address."""
        begun = f"/v1/uploads/{self.id_of(upload)}/files"
        answer = self.ask(201, "POST", begun, headers=tus_headers(path, upload.files[path]))
        assert answer.headers["upload-offset"] == str(upload.received.setdefault(path, 0))
        place = f"{begun.removesuffix('files')}{answer.headers['location']}"
        assert upload.places.setdefault(path, place) == place
        return place

    def id_of(self, upload: ModelUpload) -> str:
        return next(one for one, other in self.model.uploads.items() if other is upload)

    @precondition(lambda self: self.model.unfinished())
    @rule(pick=PICK, further=st.integers(-1, 1))
    def send_from_another_place(self, pick: int, further: int) -> None:
        upload = one_of(self.model.unfinished(), pick)
        for path, place in upload.places.items():
            if (wrong := upload.received[path] + further) not in (upload.received[path], -1):
                headers = OFFSET | {"Upload-Offset": str(wrong)}
                answer = self.ask(409, "PATCH", place, "offset-mismatch", headers=headers, content=b"x")
                assert answer.headers["upload-offset"] == str(upload.received[path])

    @precondition(lambda self: self.model.unfinished())
    @rule(pick=PICK)
    def send_the_rest(self, pick: int) -> None:
        upload = one_of(self.model.unfinished(), pick)
        for path, content in upload.files.items():
            place, begin = self.announced(upload, path), upload.received[path]
            headers = OFFSET | {"Upload-Offset": str(begin)}
            self.ask(204, "PATCH", place, headers=headers, content=content[begin:])
            upload.received[path] = len(content)

    @precondition(lambda self: self.model.uploads)
    @rule(pick=PICK)
    def finish_upload(self, pick: int) -> None:
        upload_id, upload = one_of(list(self.model.uploads.items()), pick)
        if not upload.complete:
            self.ask(409, "POST", f"/v1/uploads/{upload_id}/finish", "upload-incomplete")
            return
        told = self.ask(200, "POST", f"/v1/uploads/{upload_id}/finish").json()["capture"]
        assert told not in {one.capture for one in self.model.uploads.values() if one is not upload}
        assert upload.capture in ("", told)
        upload.capture = told
        self.model.paths.add(told)

    @precondition(lambda self: self.model.uploads)
    @rule(pick=PICK)
    def delete_upload(self, pick: int) -> None:
        upload_id, upload = one_of(list(self.model.uploads.items()), pick)
        if upload.capture and self.model.needed(upload.capture):
            self.ask(409, "DELETE", f"/v1/uploads/{upload_id}", "capture-in-use")
            return
        self.ask(204, "DELETE", f"/v1/uploads/{upload_id}")
        self.ask(404, "DELETE", f"/v1/uploads/{upload_id}", "upload-not-found")
        del self.model.uploads[upload_id]
        self.model.gone.add(upload_id)

    @precondition(lambda self: self.model.paths)
    @rule(pick=PICK, key=st.sampled_from(["", "a", "b"]), title=st.sampled_from(["", "Named"]))
    def submit(self, pick: int, key: str, title: str) -> None:
        capture = one_of(sorted(self.model.paths), pick)
        asked = {"json": {"capture": capture, "title": title}, "headers": {"Idempotency-Key": key} if key else {}}
        if self.model.content(capture) is None:
            self.ask(422, "POST", "/v1/jobs", "capture-invalid", **asked)
            return
        earlier = [(one, job) for one, job in self.model.jobs.items() if key and job.key == key]
        if earlier and (earlier[0][1].capture, earlier[0][1].title) != (capture, title):
            self.ask(422, "POST", "/v1/jobs", "idempotency-key-reused", **asked)
            return
        told = self.ask(201, "POST", "/v1/jobs", **asked).json()
        if earlier:
            assert told["id"] == earlier[0][0]
        else:
            assert told["id"] not in self.model.jobs.keys() | self.model.gone | self.model.scenes.keys()
            self.model.jobs[told["id"]] = ModelJob(capture, title, key)

    @precondition(lambda self: self.model.jobs)
    @rule(pick=PICK)
    def cancel(self, pick: int) -> None:
        job_id, job = one_of(list(self.model.jobs.items()), pick)
        if job.state in (JobState.SUCCEEDED, JobState.FAILED):
            self.ask(409, "POST", f"/v1/jobs/{job_id}/cancel", "job-finished")
        else:
            self.ask(202, "POST", f"/v1/jobs/{job_id}/cancel")
            job.state = JobState.CANCELLED

    @precondition(lambda self: self.model.jobs)
    @rule(pick=PICK)
    def retry(self, pick: int) -> None:
        job_id, job = one_of(list(self.model.jobs.items()), pick)
        if job.state in (JobState.QUEUED, JobState.RUNNING, JobState.SUCCEEDED):
            self.ask(409, "POST", f"/v1/jobs/{job_id}/retry", "job-not-retriable")
            return
        self.ask(202, "POST", f"/v1/jobs/{job_id}/retry")
        job.attempt += job.state is not JobState.WAITING
        job.state = JobState.QUEUED

    @precondition(lambda self: self.model.jobs)
    @rule(pick=PICK)
    def delete_job(self, pick: int) -> None:
        job_id, job = one_of(list(self.model.jobs.items()), pick)
        if not job.state.finished:
            self.ask(409, "DELETE", f"/v1/jobs/{job_id}", "job-not-finished")
            return
        self.ask(204, "DELETE", f"/v1/jobs/{job_id}")
        self.ask(404, "GET", f"/v1/jobs/{job_id}", "job-not-found")
        assert not self.served.home.run(job_id).exists()
        del self.model.jobs[job_id]
        self.model.gone.add(job_id)

    @precondition(lambda self: self.model.jobs)
    @rule(pick=PICK)
    def take_a_job(self, pick: int) -> None:
        queued = [(one, job) for one, job in self.model.jobs.items() if job.state is JobState.QUEUED]
        if queued:
            job_id, job = one_of(queued, pick)
            assert self.served.table.start(job_id, job.attempt) > 0
            job.state = JobState.RUNNING
            self.model.attempts.append(Attempt(job_id, job.attempt))

    @precondition(lambda self: self.model.attempts)
    @rule(pick=PICK)
    def take_an_attempt_over(self, pick: int) -> None:
        attempt = one_of(self.model.attempts, pick)
        job = self.model.current(attempt)
        assert bool(self.served.table.start(attempt.job_id, attempt.number)) == (job is not None)
        if job is not None:
            job.state = JobState.RUNNING

    @precondition(lambda self: self.model.attempts)
    @rule(pick=PICK)
    def publish(self, pick: int) -> None:
        attempt = one_of(self.model.attempts, pick)
        job = self.model.current(attempt)
        if job is None or job.state is not JobState.RUNNING:  # its stage is killed
            return
        content = self.model.content(job.capture)
        files = content if content is None else self.model.made.setdefault(attempt.job_id, content)
        if files is not None:
            self.served.make_scene(attempt.job_id)
            self.model.publish(attempt.job_id, files, json.loads(files["scene/manifest.json"])["title"])
            attempt.published = True

    @precondition(lambda self: any(attempt.published for attempt in self.model.attempts))
    @rule(pick=PICK)
    def finish_attempt(self, pick: int) -> None:
        attempt = one_of([one for one in self.model.attempts if one.published], pick)
        job = self.model.jobs.get(attempt.job_id)
        self.served.finish(attempt.job_id, attempt.number)
        self.model.attempts.remove(attempt)
        if job is not None and job.state is JobState.CANCELLED:
            self.model.scenes.pop(attempt.job_id, None)
        elif self.model.current(attempt) is job and job is not None:
            job.state = JobState.SUCCEEDED

    @precondition(lambda self: self.model.attempts)
    @rule(pick=PICK, outcome=st.sampled_from(["fails", "waits", "loses its worker"]))
    def end_attempt(self, pick: int, outcome: str) -> None:
        attempt = one_of(self.model.attempts, pick)
        job = self.model.current(attempt)
        self.model.attempts.remove(attempt)
        if outcome == "fails":
            assert self.served.table.fail(attempt.job_id, attempt.number, "it has failed") == (job is not None)
        elif outcome == "waits":
            self.served.put_off(attempt.job_id, attempt.number)
        elif job is not None:
            self.served.put_back(attempt.job_id)
        if job is not None:
            job.state = {"fails": JobState.FAILED, "waits": JobState.WAITING}.get(outcome, JobState.QUEUED)
            job.attempt += outcome == "waits"

    @precondition(lambda self: self.model.scenes)
    @rule(pick=PICK, title=st.sampled_from(["Renamed", "Twice"]))
    def rename_scene(self, pick: int, title: str) -> None:
        scene = one_of(list(self.model.scenes), pick)
        assert self.ask(200, "PATCH", f"/v1/scenes/{scene}", json={"title": title}).json()["title"] == title
        self.model.rename(scene, title)

    @precondition(lambda self: self.model.scenes)
    @rule(pick=PICK)
    def delete_scene(self, pick: int) -> None:
        scene = one_of(list(self.model.scenes), pick)
        self.ask(204, "DELETE", f"/v1/scenes/{scene}")
        self.ask(404, "DELETE", f"/v1/scenes/{scene}", "scene-not-found")
        del self.model.scenes[scene]

    @precondition(lambda self: self.model.attempts)
    @rule()
    def tidy_up(self) -> None:
        assert tidy(self.served.client, Retention(), delete=True, youngest=-1.0).jobs == ()
        assert check_store(self.served.store).sound

    @precondition(lambda self: self.requests > 25)
    @rule(killed=st.booleans())
    def start_again(self, killed: bool) -> None:
        if killed:
            self.served.die()
        else:
            self.served.stop()
        self.served.start_again()
        self.requests = 0

    @invariant()
    def uploads_are_those_of_the_model(self) -> None:
        told = self.ask(200, "GET", "/v1/uploads").json()["uploads"]
        seen = {one["id"]: (one["state"], one["received"], one["verified"], one["capture"]) for one in told}
        assert seen == {upload_id: upload.seen for upload_id, upload in self.model.uploads.items()}

    @invariant()
    def jobs_are_those_of_the_model(self) -> None:
        told = self.ask(200, "GET", "/v1/jobs?limit=1000").json()["jobs"]
        seen = {one["id"]: (one["state"], one["attempt"], one["title"]) for one in told}
        assert seen == {one: (job.state, job.attempt, job.shown_title) for one, job in self.model.jobs.items()}
        found = self.served.workflows()
        for job_id, job in self.model.jobs.items():
            if not job.state.finished:
                assert found[f"{job_id}:{job.attempt}"] in ("ENQUEUED", "DELAYED")
            elif job.state is JobState.CANCELLED:
                assert found[f"{job_id}:{job.attempt}"] == "CANCELLED"
        assert {name.rpartition(":")[0] for name in found} == self.model.jobs.keys()

    @invariant()
    def scenes_are_those_of_the_model(self) -> None:
        told = {one["id"]: one["title"] for one in self.ask(200, "GET", "/v1/scenes").json()["scenes"]}
        assert told.keys() == self.model.scenes.keys()
        for scene_id, title in told.items():
            assert title in self.model.scenes[scene_id].titles

    def teardown(self) -> None:
        try:
            self.files_are_those_of_the_model()
            self.served.stop()
        finally:
            shutil.rmtree(self.folder)

    def files_are_those_of_the_model(self) -> None:
        """Captures on the disk and scenes over HTTP have the bytes that were sent."""
        for upload in self.model.uploads.values():
            for path, content in upload.files.items() if upload.capture else ():
                assert (Path(upload.capture) / path).read_bytes() == content
        for scene_id, scene in self.model.scenes.items():
            place = f"/v1/scenes/{scene_id}"
            for path, content in scene.files.items():
                assert (
                    self.ask(200, "GET", f"{place}/{path[6:].removesuffix('.json').removesuffix('.jpg')}").content
                    == content
                )


def run(examples: int, steps: int, *, fixed: bool) -> None:
    run_state_machine_as_test(
        Service,
        settings=settings(
            max_examples=examples,
            stateful_step_count=steps,
            derandomize=fixed,
            database=None,
            deadline=None,
            suppress_health_check=list(HealthCheck),
            phases=[Phase.generate, Phase.shrink],
        ),
    )


def test_every_answer_is_the_one_of_the_model() -> None:
    run(24, 30, fixed=True)


@pytest.mark.slow
@pytest.mark.timeout(3600)
def test_every_answer_is_the_one_of_the_model_at_length() -> None:
    run(60, 60, fixed=False)
