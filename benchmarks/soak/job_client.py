"""A client that submits jobs, cancels, retries and deletes them, and renames and deletes their scenes."""

from __future__ import annotations

import hashlib
import subprocess
from pathlib import Path
from typing import Any

from benchmarks.soak.client_calls import Answer, ClientCalls
from benchmarks.soak.request_history import Act, Event
from hgs_core.base.own_modules import module_command

__all__ = ["JobActions", "job_client"]

LOOK = 0.5  # seconds between two looks at a job
PATIENCE = 600.0  # seconds for a command
CONFIG = {
    "points": {"static": 150, "dynamic": 40},
    "train": {"checkpoint_every": 10},
}


class JobActions:
    """The requests of a client of jobs and scenes."""

    def __init__(self, calls: ClientCalls) -> None:
        """Begin."""
        self.calls = calls
        self._count = 0

    def submit(self) -> str:
        """Submit a job until the server acknowledges it, and return its id; "" if the soak is over first."""
        calls = self.calls
        self._count += 1
        key = f"{calls.name}-{self._count}"
        config = {**CONFIG, "train": {**CONFIG["train"], "iterations": calls.dice.randrange(20, 60)}}
        body: dict[str, Any] = {"capture": calls.dice.choice(calls.board.captures), "title": key, "preset": "preview"}
        body |= {"hold_out": [], "config": config, "labels": [key]}
        while not calls.over:
            event = calls.note(Act.SUBMIT, key, lambda: self._submitted(key, body), _id)
            if event.acknowledged:
                calls.board.submitted.set()
                if calls.dice.random() < 0.3:  # a client may not have received the answer
                    calls.note(Act.SUBMIT, key, lambda: self._submitted(key, body), _id)
                return str(event.answer["id"])
            calls.rest(1.0)
        return ""

    def _submitted(self, key: str, body: dict[str, Any]) -> Answer:
        answer = self.calls.ask("POST", "/v1/jobs", body, {"Idempotency-Key": key})
        while answer.status == 202 and self.calls.rest(LOOK):
            answer = self.calls.ask("GET", f"/v1/submissions/{answer.body['id']}")
        return Answer(0) if answer.status == 202 else answer

    def see(self, job: str) -> str:
        """Return the state of a job; "" where it is not told."""
        event = self.calls.note(
            Act.SEE,
            job,
            lambda: self.calls.ask("GET", f"/v1/jobs/{job}"),
            lambda answer: {name: answer.body[name] for name in ("state", "stage", "attempt", "waiting", "error")},
        )
        return str(event.answer.get("state", ""))

    def until_finished(self, job: str) -> str:
        """Look at a job until it is finished, and return its state; "" if the soak is over first."""
        while self.calls.rest(LOOK):
            if (state := self.see(job)) in ("succeeded", "failed", "cancelled"):
                return state
        return ""

    def change(self, act: Act, target: str, method: str, path: str, body: dict[str, Any] | None = None) -> Event:
        """Ask for a change until it is acknowledged or refused."""
        while True:
            event = self.calls.note(act, target, lambda: self.calls.ask(method, path, body), request=body)
            if event.acknowledged or (400 <= event.status < 500 and event.status != 401) or not self.calls.rest(1.0):
                return event

    def read_scene(self, scene: str) -> bool:
        """Read a scene's manifest, and return whether it came."""
        path = f"/v1/scenes/{scene}/manifest"
        return self.calls.note(Act.READ_SCENE, scene, lambda: self.calls.ask("GET", path), _digest).acknowledged

    def publish(self, scene: str, run: Path) -> None:
        """Publish a scene that was deleted, by the command line."""

        def published() -> Answer:
            command = module_command("server.cli", "publish", str(run), "--id", scene)
            try:
                done = subprocess.run(command, check=False, capture_output=True, timeout=PATIENCE)
            except subprocess.TimeoutExpired:
                return Answer(0)
            return Answer(200 if done.returncode == 0 else 0)

        self.calls.note(Act.PUBLISH, scene, published)


def job_client(calls: ClientCalls, runs: Path) -> None:
    """Take jobs through lives of all kinds until the soak is over."""
    actions, dice = JobActions(calls), calls.dice
    while calls.rest(0.2):
        if not calls.board.captures or not (job := actions.submit()):
            continue
        if dice.random() < 0.3:
            calls.rest(dice.uniform(0, 12))
            if actions.change(Act.CANCEL, job, "POST", f"/v1/jobs/{job}/cancel").acknowledged:
                if dice.random() < 0.4:
                    actions.change(Act.DELETE_JOB, job, "DELETE", f"/v1/jobs/{job}")
                    continue
                if dice.random() < 0.3:
                    continue
                actions.change(Act.RETRY, job, "POST", f"/v1/jobs/{job}/retry")
        if actions.until_finished(job) == "succeeded":
            _use_scene(actions, job, runs / job)


def _use_scene(actions: JobActions, job: str, run: Path) -> None:
    dice = actions.calls.dice
    while not actions.read_scene(job):
        if not actions.calls.rest(1.0):
            return
    actions.calls.board.scenes.append(job)
    for number in range(dice.choice((1, 2))):
        actions.change(Act.RENAME, job, "PATCH", f"/v1/scenes/{job}", {"title": f"{job} {number}"})
    if dice.random() < 0.3:
        gone = actions.change(Act.DELETE_SCENE, job, "DELETE", f"/v1/scenes/{job}")
        if gone.acknowledged and dice.random() < 0.5:
            actions.publish(job, run)
    if dice.random() < 0.3:
        actions.change(Act.DELETE_JOB, job, "DELETE", f"/v1/jobs/{job}")


def _id(answer: Answer) -> dict[str, Any]:
    return {"id": answer.body["id"]}


def _digest(answer: Answer) -> dict[str, Any]:
    return {"manifest": hashlib.sha256(answer.data).hexdigest()}
