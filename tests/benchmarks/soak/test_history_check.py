"""A hand-made history and final state for every verdict of the checker."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

import pytest

from benchmarks.soak.final_state import FinalJob, FinalScene, FinalState
from benchmarks.soak.history_check import REVOCATION_SECONDS, Finding, Verdict, check_history
from benchmarks.soak.request_history import Act, Event


def submitted(job: str = "a", key: str = "key-a", status: int = 201) -> Event:
    return Event(Act.SUBMIT, key, status, {"id": job} if status == 201 else {})


def at(second: float, act: Act, target: str = "a", status: int = 200, **facts: dict[str, Any]) -> Event:
    return Event(act, target, status, facts.get("answer", {}), facts.get("request", {}), second, second + 0.5)


def renamed(second: float, title: str, status: int = 200) -> Event:
    return at(second, Act.RENAME, "a", status, request={"title": title})


def finished(digest: str) -> Event:
    return at(1, Act.FINISH_UPLOAD, "room", answer={"capture": "/room"}, request={"digests": {"a.jpg": digest}})


DONE = FinalJob("succeeded")
SCENE = FinalScene("A", "m")
WELL = FinalState({"a": DONE}, {"a": SCENE})


def verdicts(history: Sequence[Event], final: FinalState) -> list[Verdict]:
    return [finding.verdict for finding in check_history(history, final)]


def test_a_sound_soak_has_no_findings() -> None:
    history = [
        submitted(),
        submitted(),
        submitted("b", "key-b"),
        at(2, Act.CANCEL, "b", 202),
        at(3, Act.SEE, answer={"state": "succeeded"}),
        at(4, Act.READ_SCENE, answer={"manifest": "m"}),
        renamed(5, "A"),
        finished("1"),
        at(6, Act.ADD_KEY, "anna"),
        at(6, Act.ADD_KEY, "ben"),
        at(7, Act.REVOKE_KEY, "ben"),
        at(8, Act.USE_KEY, "ben"),
    ]
    final = dataclasses.replace(
        WELL,
        jobs={"a": DONE, "b": FinalJob("cancelled")},
        captures={"/room": {"a.jpg": "1"}},
        keys={"anna": 200, "ben": 401},
    )
    assert check_history(history, final) == []


NOTHING = FinalState()
GONE = FinalState({"a": DONE})
BROKEN: list[tuple[Verdict, list[Event], FinalState]] = [
    (Verdict.LOST_JOB, [submitted()], NOTHING),
    (
        Verdict.SUBMITTED_TWICE,
        [submitted("a"), submitted("b")],
        FinalState({"a": DONE, "b": DONE}, {"a": SCENE, "b": SCENE}),
    ),
    (
        Verdict.SUBMITTED_TWICE,
        [submitted("a", status=0)],
        FinalState(dict.fromkeys("ab", FinalJob("succeeded", labels=["key-a"])), {"a": SCENE, "b": SCENE}),
    ),
    (Verdict.DELETED_JOB_THERE, [submitted(), at(1, Act.DELETE_JOB, status=204)], WELL),
    (Verdict.CANCEL_LOST, [submitted(), at(1, Act.CANCEL, status=202)], WELL),
    (Verdict.CANCEL_LOST, [at(1, Act.RETRY, status=202), at(2, Act.CANCEL, status=202)], WELL),
    (Verdict.STUCK_JOB, [submitted()], FinalState({"a": FinalJob("queued")})),
    (Verdict.REVERTED_JOB, [at(1, Act.SEE, answer={"state": "succeeded"})], FinalState({"a": FinalJob("cancelled")})),
    (Verdict.FAILED_JOB, [submitted()], FinalState({"a": FinalJob("failed", "why")})),
    (Verdict.UNPUBLISHED, [submitted()], GONE),
    (Verdict.PUBLISHED_TWICE, [submitted()], FinalState({"a": DONE}, {"a": SCENE, "a-again": SCENE})),
    (Verdict.CHANGED_SCENE, [submitted(), at(1, Act.READ_SCENE, answer={"manifest": "other"})], WELL),
    (Verdict.DELETED_SCENE_THERE, [submitted(), at(1, Act.DELETE_SCENE, status=204)], WELL),
    (Verdict.LOST_SCENE, [at(1, Act.READ_SCENE, answer={"manifest": "m"})], NOTHING),
    (Verdict.LOST_SCENE, [at(1, Act.DELETE_SCENE, status=204), at(2, Act.PUBLISH)], GONE),
    (Verdict.LOST_TITLE, [submitted(), renamed(1, "B")], WELL),
    (Verdict.LOST_TITLE, [submitted(), renamed(1, "A"), renamed(2, "B"), renamed(3, "C", status=0)], WELL),
    (Verdict.MISSING_CHUNK, [submitted()], FinalState({"a": DONE}, {"a": FinalScene("A", "m", missing=["1"])})),
    (Verdict.DAMAGED_CHUNK, [submitted()], FinalState({"a": DONE}, {"a": FinalScene("A", "m", damaged=["1"])})),
    (
        Verdict.LOST_BYTES,
        [at(1, Act.SEND, answer={"offset": 9}), at(2, Act.ASK_OFFSET, answer={"offset": 8})],
        NOTHING,
    ),
    (Verdict.LOST_CAPTURE, [finished("1")], NOTHING),
    (Verdict.DAMAGED_CAPTURE, [finished("1")], FinalState(captures={"/room": {"a.jpg": "2"}})),
    (Verdict.LOST_KEY, [at(1, Act.ADD_KEY, "anna")], FinalState(keys={"anna": 401})),
    (Verdict.REVOKED_KEY, [at(1, Act.REVOKE_KEY, "anna")], FinalState(keys={"anna": 200})),
    (
        Verdict.REVOKED_KEY,
        [at(1, Act.REVOKE_KEY, "anna"), at(3 + REVOCATION_SECONDS, Act.USE_KEY, "anna")],
        FinalState(keys={"anna": 401}),
    ),
    (Verdict.ORPHAN, [], FinalState(stages=["python -m jobs.stage train b"])),
    (Verdict.SERVER_FAULT, [at(1, Act.CANCEL, "b", 500)], NOTHING),
]


@pytest.mark.parametrize(("verdict", "history", "final"), BROKEN, ids=[row[0].name for row in BROKEN])
def test_a_broken_promise_is_found(verdict: Verdict, history: list[Event], final: FinalState) -> None:
    assert verdict in verdicts(history, final)


def test_every_verdict_has_a_history() -> None:
    assert {row[0] for row in BROKEN} | {Verdict.ABANDONED_JOB} == set(Verdict)


def test_a_job_that_runs_needs_a_process() -> None:
    running = FinalState({"a": FinalJob("running")}, stages=["python -m jobs.stage train /home/runs/a"])
    assert Verdict.ABANDONED_JOB not in verdicts([], running)
    assert Verdict.ABANDONED_JOB in verdicts([], dataclasses.replace(running, stages=[]))


@pytest.mark.parametrize(
    ("history", "final"),
    [
        ([submitted(), at(1, Act.DELETE_JOB, status=0)], NOTHING),
        ([submitted(), at(1, Act.DELETE_SCENE, status=503)], GONE),
        ([submitted(), renamed(1, "B"), renamed(2, "A", status=0)], WELL),
        ([submitted(), at(1, Act.CANCEL, status=202), at(2, Act.RETRY, status=0)], WELL),
        ([submitted(), at(1, Act.CANCEL, status=409)], WELL),
        ([submitted(), at(1, Act.DELETE_SCENE, status=204), at(2, Act.PUBLISH)], WELL),
        ([at(1, Act.ADD_KEY, "anna"), at(2, Act.REVOKE_KEY, "anna", 0)], FinalState(keys={"anna": 401})),
        ([at(1, Act.ADD_KEY, "anna"), at(2, Act.REVOKE_KEY, "anna", 0)], FinalState(keys={"anna": 200})),
    ],
)
def test_what_nobody_promised_may_be_either_way(history: list[Event], final: FinalState) -> None:
    assert check_history(history, final) == []


def test_a_finding_comes_once() -> None:
    assert check_history([submitted(), submitted()], NOTHING) == [Finding(Verdict.LOST_JOB, "a")]
