"""The check of a soak: the promises in its history against the final state. It asks nobody and keeps nothing."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum

from benchmarks.soak.final_state import FinalState
from benchmarks.soak.request_history import Act, Event

__all__ = ["REVOCATION_SECONDS", "Finding", "Verdict", "check_history"]

REVOCATION_SECONDS = 65.0
"""The longest use of a revoked key: servers keep keys for a minute while the database is away."""

_FINISHED = ("succeeded", "failed", "cancelled")


class Verdict(StrEnum):
    """The kinds of broken promises."""

    LOST_JOB = "an acknowledged job is lost"
    SUBMITTED_TWICE = "one request made two jobs"
    DELETED_JOB_THERE = "a deleted job is there"
    CANCEL_LOST = "a cancelled job went on"
    STUCK_JOB = "a job has not ended"
    ABANDONED_JOB = "a job runs without a process"
    REVERTED_JOB = "a succeeded job is in another state"
    FAILED_JOB = "a job failed by faults that pass"
    UNPUBLISHED = "a succeeded job has no scene"
    PUBLISHED_TWICE = "a scene belongs to no job"
    CHANGED_SCENE = "a published scene was overwritten"
    DELETED_SCENE_THERE = "a deleted scene is there"
    LOST_SCENE = "a published scene is lost"
    LOST_TITLE = "a scene has not the title that it was given"
    MISSING_CHUNK = "a manifest names a chunk that is not there"
    DAMAGED_CHUNK = "a chunk has other bytes than its name says"
    LOST_BYTES = "acknowledged bytes of an upload are lost"
    LOST_CAPTURE = "a finished upload is no capture"
    DAMAGED_CAPTURE = "a capture has other bytes than were sent"
    LOST_KEY = "a key is refused"
    REVOKED_KEY = "a revoked key works"
    ORPHAN = "a process works on a run for nobody"
    SERVER_FAULT = "the server answered with a fault of its own"


@dataclass(frozen=True)
class Finding:
    """A broken promise: its kind, and the job, scene or other thing with the facts."""

    verdict: Verdict
    subject: str


def check_history(history: Sequence[Event], final: FinalState) -> list[Finding]:
    """Return all broken promises, none twice."""
    by_act: dict[Act, list[Event]] = defaultdict(list)
    for event in history:
        by_act[event.act].append(event)
    found = [
        *_jobs(by_act, final),
        *_scenes(by_act, final),
        *_uploads(by_act, final),
        *_keys(by_act, final),
        *(Finding(Verdict.ORPHAN, stage) for stage in final.stages),
        *_server_faults(history),
    ]
    return list(dict.fromkeys(found))


def _jobs(by_act: dict[Act, list[Event]], final: FinalState) -> Iterator[Finding]:
    submitted = {event.answer["id"] for event in by_act[Act.SUBMIT] if event.acknowledged}
    deleted, perhaps_deleted = _acknowledged(by_act[Act.DELETE_JOB]), _possible(by_act[Act.DELETE_JOB])
    yield from (Finding(Verdict.LOST_JOB, job) for job in sorted(submitted - final.jobs.keys() - perhaps_deleted))
    yield from (Finding(Verdict.DELETED_JOB_THERE, job) for job in sorted(deleted & final.jobs.keys()))
    yield from _submitted_twice(by_act[Act.SUBMIT], final)
    succeeded = {e.target for e in by_act[Act.SEE] if e.acknowledged and e.answer["state"] == "succeeded"}
    for name, job in final.jobs.items():
        if job.state == "running" and not any(name in stage for stage in final.stages):
            yield Finding(Verdict.ABANDONED_JOB, name)
        if job.state not in _FINISHED:
            yield Finding(Verdict.STUCK_JOB, f"{name}: {job.state}; {job.waiting}")
        if job.state == "failed":
            yield Finding(Verdict.FAILED_JOB, f"{name}: {job.error}")
        if name in succeeded and job.state != "succeeded":
            yield Finding(Verdict.REVERTED_JOB, f"{name}: {job.state}")
    for name, cancel in _last(by_act[Act.CANCEL]).items():
        retried = any(e.target == name and e.possible and e.ended > cancel.began for e in by_act[Act.RETRY])
        if name in final.jobs and final.jobs[name].state != "cancelled" and not retried:
            yield Finding(Verdict.CANCEL_LOST, f"{name}: {final.jobs[name].state}")


def _submitted_twice(submissions: Sequence[Event], final: FinalState) -> Iterator[Finding]:
    made: dict[str, set[str]] = defaultdict(set)
    for event in submissions:
        if event.acknowledged:
            made[event.target].add(event.answer["id"])
    for name, job in final.jobs.items():
        for label in job.labels:
            made[label].add(name)
    for key, jobs in made.items():
        if len(jobs) > 1:
            yield Finding(Verdict.SUBMITTED_TWICE, f"{key}: {', '.join(sorted(jobs))}")


def _scenes(by_act: dict[Act, list[Event]], final: FinalState) -> Iterator[Finding]:
    jobs = {event.answer["id"] for event in by_act[Act.SUBMIT] if event.acknowledged} | final.jobs.keys()
    perhaps_deleted = _possible(by_act[Act.DELETE_SCENE])
    for name, job in final.jobs.items():
        if job.state == "succeeded" and name not in final.scenes and name not in perhaps_deleted:
            yield Finding(Verdict.UNPUBLISHED, name)
    read = {event.target: event.answer["manifest"] for event in by_act[Act.READ_SCENE] if event.acknowledged}
    for name in sorted(read.keys() - final.scenes.keys() - perhaps_deleted):
        yield Finding(Verdict.LOST_SCENE, name)
    published = _last(by_act[Act.PUBLISH])
    for name, event in _last(by_act[Act.DELETE_SCENE]).items():
        again = [e for e in by_act[Act.PUBLISH] if e.target == name and e.possible and e.ended > event.began]
        if name in final.scenes and not again:
            yield Finding(Verdict.DELETED_SCENE_THERE, name)
    for name, event in published.items():
        later = [e for e in by_act[Act.DELETE_SCENE] if e.target == name and e.possible and e.ended > event.began]
        if name not in final.scenes and not later:
            yield Finding(Verdict.LOST_SCENE, name)
    for name, scene in final.scenes.items():
        if name not in jobs:
            yield Finding(Verdict.PUBLISHED_TWICE, name)
        if name in read and read[name] != scene.manifest:
            yield Finding(Verdict.CHANGED_SCENE, name)
        yield from (Finding(Verdict.MISSING_CHUNK, f"{name}: {chunk}") for chunk in scene.missing)
        yield from (Finding(Verdict.DAMAGED_CHUNK, f"{name}: {chunk}") for chunk in scene.damaged)
    yield from _titles(by_act, final)


def _titles(by_act: dict[Act, list[Event]], final: FinalState) -> Iterator[Finding]:
    for name, rename in _last(by_act[Act.RENAME]).items():
        after = [e for act in (Act.DELETE_SCENE, Act.PUBLISH) for e in by_act[act] if e.target == name]
        if name not in final.scenes or any(e.ended > rename.began for e in after):
            continue
        later = [e for e in by_act[Act.RENAME] if e.target == name and e.possible and e.ended > rename.began]
        if final.scenes[name].title not in {e.request["title"] for e in (rename, *later)}:
            yield Finding(Verdict.LOST_TITLE, f"{name}: {final.scenes[name].title!r}, not {rename.request['title']!r}")


def _uploads(by_act: dict[Act, list[Event]], final: FinalState) -> Iterator[Finding]:
    reached: dict[str, int] = {}
    for event in sorted((*by_act[Act.SEND], *by_act[Act.ASK_OFFSET]), key=lambda event: event.ended):
        if event.acknowledged:
            if event.act is Act.ASK_OFFSET and event.answer["offset"] < reached.get(event.target, 0):
                facts = f"{event.target}: at {event.answer['offset']}, was at {reached[event.target]}"
                yield Finding(Verdict.LOST_BYTES, facts)
            reached[event.target] = event.answer["offset"]
    gone = _possible(by_act[Act.DELETE_UPLOAD])
    for event in by_act[Act.FINISH_UPLOAD]:
        if not event.acknowledged or event.answer["capture"] in gone:
            continue
        capture = event.answer["capture"]
        if capture not in final.captures:
            yield Finding(Verdict.LOST_CAPTURE, capture)
        elif final.captures[capture] != event.request["digests"]:
            yield Finding(Verdict.DAMAGED_CAPTURE, capture)


def _keys(by_act: dict[Act, list[Event]], final: FinalState) -> Iterator[Finding]:
    revoked, perhaps = _last(by_act[Act.REVOKE_KEY]), _possible(by_act[Act.REVOKE_KEY])
    for name in sorted(_acknowledged(by_act[Act.ADD_KEY]) - perhaps):
        if final.keys.get(name) != 200:
            yield Finding(Verdict.LOST_KEY, f"{name}: {final.keys.get(name)}")
    for name, revocation in revoked.items():
        late = [e for e in by_act[Act.USE_KEY] if e.began > revocation.ended + REVOCATION_SECONDS]
        if final.keys.get(name) == 200 or any(e.target == name and e.acknowledged for e in late):
            yield Finding(Verdict.REVOKED_KEY, name)


def _server_faults(history: Iterable[Event]) -> Iterator[Finding]:
    for event in history:
        if event.status == 500:
            detail = event.answer.get("code") or event.answer.get("detail", "")
            yield Finding(Verdict.SERVER_FAULT, f"{event.act} {event.target}: {detail}")


def _acknowledged(events: Iterable[Event]) -> set[str]:
    return {event.target for event in events if event.acknowledged}


def _possible(events: Iterable[Event]) -> set[str]:
    return {event.target for event in events if event.possible}


def _last(events: Iterable[Event]) -> dict[str, Event]:
    """Return the last acknowledged event of each target."""
    return {event.target: event for event in events if event.acknowledged}
