from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.soak.request_history import Act, Event, History, read_history


def test_events_come_back_from_the_file(tmp_path: Path) -> None:
    history = History(tmp_path / "history.jsonl")
    events = [
        Event(Act.SUBMIT, "key-1", 201, {"id": "a"}, {"capture": "room"}, 1.0, 1.5, "jobs-0"),
        Event(Act.CANCEL, "a", 0),
    ]
    for event in events:
        history.note(event)
    history.close()
    assert list(read_history(tmp_path / "history.jsonl")) == events


@pytest.mark.parametrize(
    ("status", "acknowledged", "possible"),
    [(201, True, True), (0, False, True), (503, False, True), (409, False, False), (404, False, False)],
)
def test_what_has_no_answer_may_have_happened(status: int, acknowledged: bool, possible: bool) -> None:
    event = Event(Act.CANCEL, "a", status)
    assert (event.acknowledged, event.possible) == (acknowledged, possible)
