from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from benchmarks.soak.curve_slopes import Slope
from benchmarks.soak.history_check import Finding, Verdict
from benchmarks.soak.process_curves import Sample
from benchmarks.soak.request_history import Act, Event
from benchmarks.soak.soak_report import SoakResult, waits_of, write_report

SOUND = SoakResult({"succeeded": 3}, [], [Slope("api", "memory", 0.1)], {"kill the API": 2}, {"longest job": 9.0}, [])


def changed(**parts: Any) -> SoakResult:
    return SoakResult(**{**vars(SOUND), **parts})


def test_a_soak_is_sound_when_work_was_done_and_nothing_was_found() -> None:
    assert SOUND.sound
    assert SOUND.lines()[-1].startswith("sound")
    for bad in (
        changed(findings=[Finding(Verdict.LOST_JOB, "a")]),
        changed(slopes=[Slope("api", "memory", 99.0)]),
        changed(facts={}),
    ):
        assert not bad.sound
        assert not bad.lines()[-1].startswith("sound")


def test_waits_are_those_of_viewers_and_of_jobs() -> None:
    history = [
        Event(Act.SUBMIT, "key", 201, {"id": "a"}, {}, 1.0, 2.0),
        Event(Act.SUBMIT, "key", 201, {"id": "a"}, {}, 3.0, 4.0),
        Event(Act.SEE, "a", 200, {"state": "succeeded"}, {}, 11.5, 12.0),
        Event(Act.WATCH, "a", 200, {"start": 0.5, "waited": 2.0}),
        Event(Act.WATCH, "a", 200, {"start": 1.5, "waited": 1.0}),
        Event(Act.WATCH, "a", 200, {"start": None, "waited": 0.0}, {"seconds": 8.0}),
        Event(Act.WATCH, "b", 404),
    ]
    assert waits_of(history) == {
        "first picture (median)": 1.5,
        "first picture (longest)": 8.0,
        "longest stall": 2.0,
        "all stalls": 3.0,
        "longest job": 10.0,
    }


def test_the_page_has_verdict_and_curves(tmp_path: Path) -> None:
    samples = {"api": [Sample(float(t), 1, 100.0 + t, 9, 3, 2) for t in range(5)]}
    page = write_report(tmp_path, SOUND, samples, {"runs": [(0.0, 1.0), (10.0, 2.0)]}).read_text()
    assert "sound" in page
    assert page.count("<svg") == 5
    assert json.loads((tmp_path / "report.json").read_text())["faults"] == {"kill the API": 2}
