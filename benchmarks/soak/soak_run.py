"""One soak: a service, its clients, their faults, and the check of everything afterwards."""

from __future__ import annotations

import contextlib
import os
import shutil
from collections import Counter
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any

from benchmarks.soak.client_calls import Board, ClientCalls
from benchmarks.soak.curve_slopes import slopes
from benchmarks.soak.fault_injection import FaultInjection
from benchmarks.soak.fault_plan import plan_faults
from benchmarks.soak.final_state import settled, state_of
from benchmarks.soak.history_check import check_history
from benchmarks.soak.job_client import job_client
from benchmarks.soak.key_client import KeyDesk, key_client
from benchmarks.soak.process_curves import Curves
from benchmarks.soak.request_history import Act, History, read_history
from benchmarks.soak.scene_viewers import watch_scenes
from benchmarks.soak.soak_report import SoakResult, waits_of, write_report
from benchmarks.soak.soaked_service import Extras, SoakedService
from benchmarks.soak.upload_client import CaptureFiles, upload_client
from tests.synthetic import write_capture

__all__ = ["soak"]

JOB_CLIENTS = 3
VIEWERS = 2
FIRST_JOB = 1800.0  # seconds that the first job may be late on a busy machine
SETTLE = 180.0  # seconds without progress after which the last jobs are stuck


def soak(folder: Path, seed: int, minutes: float, extras: Extras, say: Callable[[str], None] = print) -> SoakResult:
    """Soak a service for so many minutes, and return the result; its report lies in the new `folder`."""
    write_capture(folder / "capture", cameras=4, frames=4, width=48, height=36)
    history_file = folder / "history.jsonl"
    with SoakedService(folder, extras) as service:
        os.environ.update(service.own_home.environment())  # commands of clients read it
        service.until_ready()
        history = History(history_file)
        board = Board(service.address, service.admin_key, history)
        say(f"seed {seed}: {minutes:g} minutes; {folder}")
        curves = Curves(service.pids, service.disk_folders, lambda: history.now)
        curves.start()
        faults = _suffer(service, board, seed, 60 * minutes)
        curves.stop()
        operator = ClientCalls("operator", board, seed)
        service.until_ready()
        took = settled(operator, SETTLE)
        history.close()
        events = list(read_history(history_file))
        finished = [event for event in events if event.act is Act.FINISH_UPLOAD and event.acknowledged]
        _keep_logs(service.own_home.runs, folder / "stages")
        final = state_of(service.own_home, operator, [event.answer["capture"] for event in finished])
    facts: dict[str, Any] = {"seed": seed, "minutes": minutes, "requests": len(events)}
    facts |= {"acknowledged": sum(event.acknowledged for event in events)}
    facts |= Counter(job.state for job in final.jobs.values())
    facts |= {"scenes": len(final.scenes), "captures": len(final.captures), "keys": len(final.keys)}
    facts |= {"views": sum(event.act is Act.WATCH for event in events), "seconds to settle": round(took, 1)}
    found = check_history(events, final)
    result = SoakResult(facts, found, slopes(curves.samples), faults, waits_of(events), extras.missing())
    say(f"report: {write_report(folder, result, curves.samples, curves.disk)}")
    return result


def _keep_logs(runs: Path, folder: Path) -> None:
    """Copy the logs of stages from the home, which may lie on a disk that goes with the soak."""
    folder.mkdir()
    for log in runs.glob("*/stage.log"):
        with contextlib.suppress(FileNotFoundError):
            shutil.copy(log, folder / f"{log.parent.name}.log")


def _suffer(service: SoakedService, board: Board, seed: int, seconds: float) -> dict[str, int]:
    """Let clients work while faults are met; return how often each was, once all is healed and every client has left.

    Raises:
        Exception: a fault of a client's own.
    """
    calls = partial(ClientCalls, board=board, seed=seed)
    desk = KeyDesk(calls("keys"), service.home)
    sent, runs = CaptureFiles.of(service.folder / "capture"), service.own_home.runs
    works: list[Callable[[], None]] = [
        *(partial(job_client, calls(f"jobs-{number}"), runs) for number in range(JOB_CLIENTS)),
        partial(upload_client, calls("room"), sent),
        partial(key_client, desk),
        partial(watch_scenes, calls("viewers"), VIEWERS),
    ]
    injection = FaultInjection(service, desk, board.history)
    with ThreadPoolExecutor(len(works)) as pool:
        try:
            clients = [pool.submit(work) for work in works]
            for client in clients:
                client.add_done_callback(lambda _: board.stop.set())
            injection.run(plan_faults(seed, seconds), board.stop)
            board.stop.wait(max(0.0, seconds - board.history.now))
            while not board.submitted.wait(1.0) and not board.stop.is_set() and board.history.now < seconds + FIRST_JOB:
                pass
        finally:
            board.stop.set()
            injection.heal()
    for client in clients:
        client.result()
    return {str(kind): times for kind, times in injection.met.items()}
