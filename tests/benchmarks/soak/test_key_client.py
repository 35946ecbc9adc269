from __future__ import annotations

import dataclasses
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from pathlib import Path
from typing import Any

from benchmarks.soak.client_calls import Answer, Board
from benchmarks.soak.key_client import KeyDesk, key_client
from benchmarks.soak.request_history import Act, Event
from jobs.home.home import Home
from jobs.records.keys import KeyTable

Scripted = Callable[[Callable[[str, str, Any], Answer]], Any]


def names(home: Home) -> list[str]:
    with closing(KeyTable(home)) as table:
        return [key.name for key in table.all()]


def test_a_rotation_gives_all_a_new_key_and_revokes_the_old_one(
    board: Board, scripted: Scripted, tmp_path: Path
) -> None:
    home = Home.at(tmp_path)
    desk = KeyDesk(scripted(lambda method, path, body: Answer(200)), home)
    desk.rotate()
    first = board.key
    desk.rotate()
    assert board.key != first
    assert names(home) == ["client-2"]


def test_rotations_that_come_together_revoke_each_key_once(scripted: Scripted, tmp_path: Path) -> None:
    home = Home.at(tmp_path)
    desk = KeyDesk(scripted(lambda method, path, body: Answer(200)), home)
    desk.rotate()
    with ThreadPoolExecutor(2) as pool:
        for rotation in [pool.submit(desk.rotate) for _ in range(2)]:
            rotation.result()
    assert names(home) == ["client-3"]


def test_an_absent_database_is_no_answer(
    board: Board, scripted: Scripted, noted: Callable[[], list[Event]], tmp_path: Path
) -> None:
    home = dataclasses.replace(Home.at(tmp_path), database_url="postgresql://hgs@127.0.0.1:1/x")
    desk = KeyDesk(scripted(lambda method, path, body: Answer(200)), home)
    desk.rotate()
    assert [(event.act, event.status) for event in noted()] == [(Act.ADD_KEY, 0)]
    assert board.key == "hgs_key"


def test_revoked_keys_are_used_too(
    board: Board, scripted: Scripted, noted: Callable[[], list[Event]], tmp_path: Path
) -> None:
    def answer(method: str, path: str, body: Any) -> Answer:
        if sum(event.act is Act.REVOKE_KEY for event in noted()) == 2:
            board.stop.set()
        return Answer(200)

    key_client(KeyDesk(scripted(answer), Home.at(tmp_path)))
    revoked = [event for event in noted() if event.act is Act.REVOKE_KEY]
    used = [event for event in noted() if event.act is Act.USE_KEY]
    assert any(use.target == one.target and use.began >= one.ended for one in revoked for use in used)
