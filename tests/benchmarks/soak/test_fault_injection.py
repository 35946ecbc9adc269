from __future__ import annotations

import signal
import struct
import threading
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from benchmarks.soak import fault_injection
from benchmarks.soak.client_calls import Board
from benchmarks.soak.fault_injection import MOST_KILLS, FaultInjection
from benchmarks.soak.fault_plan import Fault, PlannedFault
from benchmarks.soak.request_history import Act, Event
from benchmarks.soak.stepped_clock import SteppedClock


class Doubles:
    """A service that notes the things that are done to it."""

    def __init__(self, folder: Path) -> None:
        self.done: list[str] = []
        self.store_door, self.database_door, self.client_door = (
            self.double(name, "refuse", "hang", "answer_late", "drop", "pass_on") for name in ("s3", "db", "clients")
        )
        self.database = self.double("Postgres", "stop", "start")
        self.processes = {role: self.double(role, "signal") for role in ("api", "worker 1", "worker 2", "collector")}
        self.workers = [self.processes["worker 1"], self.processes["worker 2"]]
        self.home = SimpleNamespace(runs=folder / "runs", folder=folder)
        self.extras = SimpleNamespace(small_disk=False)
        self.starting = self.overdue = False
        self.clocks = {"api": SteppedClock(Path("none"), folder / "clock")}

    def at_work(self, process: Any) -> bool:
        return not self.starting

    def double(self, role: str, *acts: str) -> Any:
        def note(act: str) -> Callable[..., None]:
            return lambda *facts: self.done.append(" ".join((role, act, *(str(int(fact)) for fact in facts))))

        return SimpleNamespace(role=role, **{act: note(act) for act in acts})


@pytest.fixture
def service(tmp_path: Path) -> Doubles:
    return Doubles(tmp_path)


@pytest.fixture
def injection(service: Doubles, board: Board) -> FaultInjection:
    desk = SimpleNamespace(rotate=lambda: service.done.append("rotate"))
    return FaultInjection(service, desk, board.history)  # type: ignore[arg-type]


EXPECTED = {
    Fault.KILL_API: ["api signal 9"],
    Fault.STOP_API: ["api signal 15"],
    Fault.KILL_WORKER: ["worker 2 signal 9"],
    Fault.STOP_WORKER: ["worker 2 signal 15"],
    Fault.KILL_COLLECTOR: ["collector signal 9"],
    Fault.PAUSE_WORKER: [f"worker 2 signal {int(signal.SIGSTOP)}", f"worker 2 signal {int(signal.SIGCONT)}"],
    Fault.RESTART_DATABASE: ["Postgres stop", "Postgres start"],
    Fault.DROP_DATABASE: ["db drop"],
    Fault.STORE_REFUSES: ["s3 refuse", "s3 pass_on"],
    Fault.STORE_HANGS: ["s3 hang", "s3 pass_on"],
    Fault.STORE_LATE: ["s3 answer_late 1", "s3 pass_on"],
    Fault.DROP_STORE: ["s3 drop"],
    Fault.DROP_CLIENTS: ["clients drop"],
    Fault.ROTATE_KEYS: ["rotate"],
    Fault.KILL_STAGE: [],  # there is none
    Fault.FULL_DISK: [],  # nor a disk that may be filled
    Fault.STEP_CLOCK: [],  # seen in the clock
}


@pytest.mark.parametrize("kind", Fault)
def test_a_fault_is_met_and_noted(
    kind: Fault, injection: FaultInjection, service: Doubles, noted: Callable[[], list[Event]]
) -> None:
    injection.run([PlannedFault(0.0, kind, 0.0, 0.7)], threading.Event())
    for thread in injection._healing:
        thread.join()
    assert service.done == EXPECTED[kind]
    met = bool(EXPECTED[kind]) or kind is Fault.STEP_CLOCK
    assert injection.met[kind] == met
    assert [(event.act, event.target) for event in noted()] == [(Act.FAULT, kind)] * met


@pytest.mark.parametrize("kind", [Fault.KILL_API, Fault.STOP_API, Fault.KILL_WORKER, Fault.KILL_COLLECTOR])
def test_a_process_that_only_starts_is_left_alone(kind: Fault, injection: FaultInjection, service: Doubles) -> None:
    service.starting = True
    injection.run([PlannedFault(0.0, kind, 0.0, 0.7)], threading.Event())
    for thread in injection._healing:
        thread.join()
    assert (service.done, injection.met[kind]) == ([], 0)


@pytest.mark.parametrize("kind", [Fault.DROP_DATABASE, Fault.RESTART_DATABASE, Fault.STORE_REFUSES])
def test_a_service_that_starts_for_long_is_left_alone(kind: Fault, injection: FaultInjection, service: Doubles) -> None:
    service.overdue = True
    injection.run([PlannedFault(0.0, kind, 0.0, 0.7)], threading.Event())
    for thread in injection._healing:
        thread.join()
    assert (service.done, injection.met[kind]) == ([], 0)


def test_a_clock_is_stepped_and_put_right(
    injection: FaultInjection, service: Doubles, monkeypatch: pytest.MonkeyPatch
) -> None:
    steps: list[float] = []
    monkeypatch.setattr(SteppedClock, "step_to", lambda self, seconds: steps.append(seconds))
    injection.run([PlannedFault(0.0, Fault.STEP_CLOCK, 0.0, 0.7)], threading.Event())
    injection._healing[0].join()
    assert steps == [3600.0, 0.0]
    assert struct.unpack("d", service.home.folder.joinpath("clock").read_bytes()) == (0.0,)


def test_stages_of_one_job_are_killed_twice_at_most(injection: FaultInjection, monkeypatch: pytest.MonkeyPatch) -> None:
    killed: list[int] = []
    monkeypatch.setattr(fault_injection, "stage_processes", lambda runs: {7: "jobs.stage train /runs/a"})
    monkeypatch.setattr(fault_injection.os, "kill", lambda pid, number: killed.append(pid))
    for _ in range(MOST_KILLS + 2):
        injection._meet(PlannedFault(0.0, Fault.KILL_STAGE, 0.0, 0.0), threading.Event())
    assert killed == [7] * MOST_KILLS


def test_healing_opens_all_doors_and_wakes_all(injection: FaultInjection, service: Doubles) -> None:
    injection.heal()
    assert {"s3 pass_on", "db pass_on", "clients pass_on"} <= set(service.done)
    assert f"worker 1 signal {int(signal.SIGCONT)}" in service.done
