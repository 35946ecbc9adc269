"""Faults carried out on a running service."""

from __future__ import annotations

import contextlib
import os
import signal
import threading
import time
from collections import Counter
from collections.abc import Callable

from benchmarks.soak.fault_plan import Fault, PlannedFault
from benchmarks.soak.key_client import KeyDesk
from benchmarks.soak.request_history import Act, Event, History
from benchmarks.soak.soaked_service import SoakedService
from benchmarks.soak.supervised import SupervisedProcess, stage_processes

__all__ = ["FaultInjection"]

MOST_KILLS = 2  # signals to the stages of one job: after three without progress it fails, and may
LATE = 1.0  # seconds
CLOCKS = (3600.0, -3600.0, 90000.0, -30.0)  # seconds


class FaultInjection:
    """Meets a service with the faults of a plan, each at its moment, and heals it."""

    def __init__(self, service: SoakedService, desk: KeyDesk, history: History) -> None:
        """Prepare."""
        self._service, self._desk, self._history = service, desk, history
        self._killed: Counter[str] = Counter()
        self._turn = threading.Lock()  # one outage of Postgres or S3 at a time
        self._healing: list[threading.Thread] = []
        self.met: Counter[Fault] = Counter()

    def run(self, plan: list[PlannedFault], over: threading.Event) -> None:
        """Carry a plan out, unless it is over before."""
        for fault in plan:
            if over.wait(max(0.0, fault.at - self._history.now)):
                return
            thread = threading.Thread(target=self._meet, args=(fault, over), daemon=True)
            thread.start()
            self._healing.append(thread)

    def heal(self) -> None:
        """Wait for the ends of all faults, and undo their remains."""
        for thread in self._healing:
            thread.join()
        for door in (self._service.store_door, self._service.database_door, self._service.client_door):
            door.pass_on()
        for process in self._service.processes.values():
            process.signal(signal.SIGCONT)

    def _meet(self, fault: PlannedFault, over: threading.Event) -> None:
        if self._service.overdue:  # faults of links and database would keep it from ever starting
            return
        began = self._history.now
        act = self._acts()[fault.kind]
        if victim := act(fault, over):
            self.met[fault.kind] += 1
            facts = {"victim": victim, "seconds": round(fault.seconds, 1)}
            self._history.note(Event(Act.FAULT, fault.kind, 200, facts, {}, began, self._history.now))

    def _acts(self) -> dict[Fault, Callable[[PlannedFault, threading.Event], str]]:
        """Return the function of each kind; it returns its victim, or "" where nothing could be done."""
        service, processes = self._service, self._service.processes
        kill, term = signal.SIGKILL, signal.SIGTERM
        store, database, clients = service.store_door, service.database_door, service.client_door
        return {
            Fault.KILL_STAGE: lambda fault, over: self._kill_stage(fault),
            Fault.KILL_WORKER: lambda fault, over: self._end(self._worker(fault), kill),
            Fault.KILL_API: lambda fault, over: self._end(processes["api"], kill),
            Fault.KILL_COLLECTOR: lambda fault, over: self._end(processes["collector"], kill),
            Fault.STOP_WORKER: lambda fault, over: self._end(self._worker(fault), term),
            Fault.STOP_API: lambda fault, over: self._end(processes["api"], term),
            Fault.PAUSE_WORKER: self._pause_worker,
            Fault.RESTART_DATABASE: self._restart_database,
            Fault.DROP_DATABASE: lambda fault, over: _done(database.drop, "all"),
            Fault.STORE_REFUSES: lambda fault, over: self._spoil_store(store.refuse, fault, over),
            Fault.STORE_HANGS: lambda fault, over: self._spoil_store(store.hang, fault, over),
            Fault.STORE_LATE: lambda fault, over: self._spoil_store(lambda: store.answer_late(LATE), fault, over),
            Fault.DROP_STORE: lambda fault, over: _done(store.drop, "all"),
            Fault.DROP_CLIENTS: lambda fault, over: _done(clients.drop, "all"),
            Fault.FULL_DISK: self._fill_disk,
            Fault.STEP_CLOCK: self._step_clock,
            Fault.ROTATE_KEYS: lambda fault, over: _done(self._desk.rotate, "clients"),
        }

    def _worker(self, fault: PlannedFault) -> SupervisedProcess:
        workers = self._service.workers
        return workers[int(fault.choice * len(workers))]

    def _end(self, process: SupervisedProcess, number: signal.Signals) -> str:
        """End a process, unless it has not begun its work: on a busy machine none would ever begin."""
        if not self._service.at_work(process):
            return ""
        process.signal(number)
        return process.role

    def _kill_stage(self, fault: PlannedFault) -> str:
        stages = stage_processes(self._service.home.runs)
        left = sorted(pid for pid, line in stages.items() if self._killed[line.rpartition("/")[2]] < MOST_KILLS)
        if not left:
            return ""
        pid = left[int(fault.choice * len(left))]
        self._killed[stages[pid].rpartition("/")[2]] += 1
        with contextlib.suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)
        return stages[pid]

    def _pause_worker(self, fault: PlannedFault, over: threading.Event) -> str:
        worker = self._worker(fault)
        worker.signal(signal.SIGSTOP)
        over.wait(fault.seconds)
        worker.signal(signal.SIGCONT)
        return worker.role

    def _spoil_store(self, begin: Callable[[], object], fault: PlannedFault, over: threading.Event) -> str:
        with self._turn:
            begin()
            over.wait(fault.seconds)
            self._service.store_door.pass_on()
        return "S3"

    def _restart_database(self, fault: PlannedFault, over: threading.Event) -> str:
        with self._turn:
            self._service.database.stop()
            over.wait(fault.seconds)
            self._service.database.start()
        return "Postgres"

    def _fill_disk(self, fault: PlannedFault, over: threading.Event) -> str:
        if not self._service.extras.small_disk:
            return ""
        ballast, until = self._service.home.folder / "ballast", time.monotonic() + fault.seconds
        while time.monotonic() < until and not over.is_set():
            with contextlib.suppress(OSError), ballast.open("ab", buffering=0) as file:
                while True:
                    file.write(bytes(4096))
            over.wait(0.2)
        ballast.unlink(missing_ok=True)
        return "home"

    def _step_clock(self, fault: PlannedFault, over: threading.Event) -> str:
        if not (roles := sorted(self._service.clocks)):
            return ""
        role = roles[int(fault.choice * len(roles))]
        offset = CLOCKS[int(fault.choice * 1000) % len(CLOCKS)]
        self._service.clocks[role].step_to(offset)
        over.wait(fault.seconds)
        self._service.clocks[role].step_to(0.0)
        return f"{role} {offset:+g} s"


def _done(act: Callable[[], object], victim: str) -> str:
    act()
    return victim
