"""The state of a service after a soak: everything that its promises can be compared with."""

from __future__ import annotations

import hashlib
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from benchmarks.soak.client_calls import Answer, ClientCalls
from benchmarks.soak.supervised import stage_processes
from jobs.artifacts.artifact_store import open_store
from jobs.artifacts.store_check import check_store
from jobs.home.home import Home

__all__ = ["FinalJob", "FinalScene", "FinalState", "settled", "state_of"]

LEAVING = 180.0  # seconds for the last stages to end
PATIENCE = 600.0  # seconds for an answer that is none of a fault
LONGEST = 10  # times the wait without progress


@dataclass(frozen=True)
class FinalJob:
    """A job of the list."""

    state: str
    error: str = ""
    waiting: str = ""
    labels: Sequence[str] = ()  # idempotency keys of its submission


@dataclass(frozen=True)
class FinalScene:
    """A published scene."""

    title: str
    manifest: str  # SHA-256
    missing: Sequence[str] = ()  # chunks that the store lacks
    damaged: Sequence[str] = ()


@dataclass(frozen=True)
class FinalState:
    """Jobs, scenes and uploaded captures by their ids, and the rest of a service that has settled."""

    jobs: Mapping[str, FinalJob] = field(default_factory=dict)
    scenes: Mapping[str, FinalScene] = field(default_factory=dict)
    captures: Mapping[str, Mapping[str, str]] = field(default_factory=dict)  # SHA-256 by file
    keys: Mapping[str, int] = field(default_factory=dict)  # status of a request with each
    stages: Sequence[str] = ()  # command lines of processes that still work on runs


def settled(calls: ClientCalls, seconds: float) -> float:
    """Wait until no job is unfinished, as long as some job goes on within so many seconds; return the seconds it took.

    A busy machine makes jobs slow, and not stuck.
    """
    began = went_on = time.monotonic()
    before: list[tuple[Any, ...]] = []
    while (now := time.monotonic()) - went_on < seconds and now - began < LONGEST * seconds:
        answer = calls.ask("GET", "/v1/jobs?limit=1000")
        if answer.ok:
            places = [(job["id"], job["state"], job["progress"]) for job in answer.body["jobs"]]
            if all(job["state"] in ("succeeded", "failed", "cancelled") for job in answer.body["jobs"]):
                break
            if places != before:
                before, went_on = places, now
        time.sleep(1.0)
    return time.monotonic() - began


def state_of(home: Home, calls: ClientCalls, captures: Sequence[str]) -> FinalState:
    """Return the state of a healed service, by its API and its store; `captures` are the uploaded ones to read.

    Raises:
        ConnectionError: the API gives no list.
    """
    until = time.monotonic() + LEAVING
    while stage_processes(home.runs) and time.monotonic() < until:
        time.sleep(0.5)
    jobs = {
        job["id"]: FinalJob(job["state"], job["error"] or "", job["waiting"] or "", job["labels"])
        for job in _listed(calls, "jobs", "?limit=1000")
    }
    store = open_store(home)
    found = check_store(store)
    scenes = {}
    for scene in _listed(calls, "scenes"):
        missing = [fault.chunk for fault in found.faults if scene["id"] in fault.scenes and fault.problem == "missing"]
        damaged = [fault.chunk for fault in found.faults if scene["id"] in fault.scenes and fault.problem != "missing"]
        digest = hashlib.sha256(store.manifest(scene["id"]) or b"").hexdigest()
        scenes[scene["id"]] = FinalScene(scene["title"], digest, missing, damaged)
    keys = {name: _answered(calls, "/v1/scenes", text).status for name, text in calls.board.keys.items()}
    stages = list(stage_processes(home.runs).values())
    return FinalState(jobs, scenes, {folder: _digests(Path(folder)) for folder in captures}, keys, stages)


def _listed(calls: ClientCalls, name: str, query: str = "") -> list[dict[str, Any]]:
    answer = _answered(calls, f"/v1/{name}{query}")
    if not answer.ok:
        raise ConnectionError(f"the list of {name} was answered with {answer.status}")
    found: list[dict[str, Any]] = answer.body[name]
    return found


def _answered(calls: ClientCalls, path: str, key: str = "") -> Answer:
    """Ask a healed service until it answers: a busy machine may make it late."""
    until = time.monotonic() + PATIENCE
    while (answer := calls.ask("GET", path, key=key)).status in (0, 503) and time.monotonic() < until:
        time.sleep(1.0)
    return answer


def _digests(folder: Path) -> dict[str, str]:
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    return {path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}
