from __future__ import annotations

import hashlib
import itertools
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from benchmarks.soak import final_state
from benchmarks.soak.client_calls import Answer, Board
from benchmarks.soak.final_state import FinalJob, settled, state_of
from jobs.artifacts.artifact_store import open_store
from jobs.home.home import Home
from tests.chunks import static_chunk
from tests.jobs.modules.scene_folder import write_scene

Scripted = Callable[[Callable[[str, str, Any], Answer]], Any]


def job(state: str, done: int = 0) -> dict[str, Any]:
    progress = {"stage": "train", "done": done, "total": 9}
    return {"id": "a", "state": state, "error": None, "waiting": None, "labels": ["key"], "progress": progress}


@pytest.fixture
def moments(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let every look at the clock be a second later, and nobody sleep."""
    clock = itertools.count()
    quick = SimpleNamespace(monotonic=lambda: float(next(clock)), sleep=lambda seconds: None)
    monkeypatch.setattr(final_state, "time", quick)


def test_everything_is_read_from_api_store_and_files(board: Board, scripted: Scripted, tmp_path: Path) -> None:
    home = Home.at(tmp_path / "home")
    write_scene(tmp_path / "scene", (static_chunk(b"1"), static_chunk(b"2")))
    store = open_store(home)
    store.put_scene(tmp_path / "scene", "a")
    first, second = sorted(chunk.id for chunk in store.list_chunks())
    store.remove_chunks([first])
    (tmp_path / "home" / "store" / "chunks" / second).write_bytes(b"x")
    (tmp_path / "room").mkdir()
    (tmp_path / "room" / "0.jpg").write_bytes(b"picture")
    board.keys["anna"] = "hgs_anna"

    def answer(method: str, path: str, body: Any) -> Answer:
        return Answer(200, {"jobs": [job("succeeded")], "scenes": [{"id": "a", "title": "A"}]})

    found = state_of(home, scripted(answer), [str(tmp_path / "room")])
    assert found.jobs == {"a": FinalJob("succeeded", labels=["key"])}
    assert (found.scenes["a"].title, found.scenes["a"].missing, found.scenes["a"].damaged) == ("A", [first], [second])
    assert found.scenes["a"].manifest == hashlib.sha256((tmp_path / "scene" / "manifest.json").read_bytes()).hexdigest()
    assert found.captures == {str(tmp_path / "room"): {"0.jpg": hashlib.sha256(b"picture").hexdigest()}}
    assert (found.keys, found.stages) == ({"anna": 200}, [])


def test_an_api_that_gives_no_list_is_no_empty_service(scripted: Scripted, tmp_path: Path, moments: None) -> None:
    with pytest.raises(ConnectionError, match="503"):
        state_of(Home.at(tmp_path), scripted(lambda method, path, body: Answer(503)), [])


def test_a_service_has_settled_when_all_jobs_are_finished(scripted: Scripted, moments: None) -> None:
    answers = iter([Answer(0), Answer(200, {"jobs": [job("running")]}), Answer(200, {"jobs": [job("failed")]})])
    settled(scripted(lambda method, path, body: next(answers)), 1000.0)
    assert next(answers, None) is None


def test_jobs_that_go_on_are_waited_for_and_those_that_do_not_are_not(scripted: Scripted, moments: None) -> None:
    answers = [Answer(200, {"jobs": [job("running", min(look, 20))]}) for look in range(100)]
    left = iter(answers)
    took = settled(scripted(lambda method, path, body: next(left)), 10.0)
    assert 20 < took < 40


def test_a_late_answer_of_a_healed_service_is_waited_for(
    board: Board, scripted: Scripted, tmp_path: Path, moments: None
) -> None:
    board.keys["anna"] = "hgs_anna"
    asked: Counter[str] = Counter()

    def answer(method: str, path: str, body: Any) -> Answer:
        asked[path] += 1
        return Answer(200, {"jobs": [], "scenes": []}) if asked[path] > 1 else Answer(0)

    assert state_of(Home.at(tmp_path / "home"), scripted(answer), []).keys == {"anna": 200}
