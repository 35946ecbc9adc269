"""The state of a service after a soak: everything that its promises can be compared with."""

from __future__ import annotations

import hashlib
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from benchmarks.soak.client_calls import ClientCalls
from benchmarks.soak.supervised import stage_processes
from jobs.artifacts.artifact_store import open_store
from jobs.artifacts.store_check import check_store
from jobs.home.home import Home

__all__ = ["FinalJob", "FinalScene", "FinalState", "settled", "state_of"]

LEAVING = 20.0  # seconds for the last stages to end


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
    """Wait until no job is unfinished, for so long at most; return the seconds that it took."""
    began = time.monotonic()
    while (passed := time.monotonic() - began) < seconds:
        answer = calls.ask("GET", "/v1/jobs?limit=1000")
        if answer.ok and all(job["state"] in ("succeeded", "failed", "cancelled") for job in answer.body["jobs"]):
            return passed
        time.sleep(1.0)
    return passed


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
    keys = {name: calls.ask("GET", "/v1/scenes", key=text).status for name, text in calls.board.keys.items()}
    stages = list(stage_processes(home.runs).values())
    return FinalState(jobs, scenes, {folder: _digests(Path(folder)) for folder in captures}, keys, stages)


def _listed(calls: ClientCalls, name: str, query: str = "") -> list[dict[str, Any]]:
    answer = calls.ask("GET", f"/v1/{name}{query}")
    if not answer.ok:
        raise ConnectionError(f"the list of {name} was answered with {answer.status}")
    found: list[dict[str, Any]] = answer.body[name]
    return found


def _digests(folder: Path) -> dict[str, str]:
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    return {path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}
