from __future__ import annotations

import os
import socket
import time
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from benchmarks.soak.soaked_service import STARTING, Extras, SoakedService


def test_it_is_said_what_is_left_out() -> None:
    assert len(Extras().missing()) == 3
    assert Extras(old_revision="HEAD~1", small_disk=True, clocks=True).missing() == []


def test_the_api_is_at_work_when_it_answers_and_a_worker_when_it_has_a_connection(tmp_path: Path) -> None:
    service = SoakedService(tmp_path, Extras())
    roles: dict[str, Any] = {role: SimpleNamespace(role=role, pid=-1) for role in ("api", "worker 1", "other")}
    service.processes = roles
    assert [service.at_work(process) for process in roles.values()] == [False, False, True]
    roles["worker 1"].pid = os.getpid()
    with socket.socket():  # one of this process
        assert service.at_work(roles["worker 1"])


def test_an_api_is_overdue_when_it_has_not_answered_long_after_its_start(tmp_path: Path) -> None:
    service = SoakedService(tmp_path, Extras())
    api: Any = SimpleNamespace(role="api", pid=-1, began=time.monotonic())
    service.processes = {"api": api}
    assert not service.overdue
    api.began -= STARTING + 1.0
    assert service.overdue
