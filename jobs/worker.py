"""A worker: a process that takes jobs from the queue, one at a time: `python -m jobs.worker`."""

from __future__ import annotations

import argparse
import logging
import os
import secrets
import signal
import socket
import subprocess
import sys
import threading
import time
from typing import Any, NoReturn

from dbos import DBOS, DBOSPortableJSONSerializer

from hgs_core.base.errors import InputError
from hgs_core.base.own_modules import guard_imports, module_command
from jobs.home.database import APPLICATION, create_engine, dbos_url, open_client, prepare_database
from jobs.home.home import Home
from jobs.process.parent_process import when_parent_is_gone
from jobs.process.stage_environment import keep_secrets
from jobs.process.stage_runner import GRACE, StageRunner
from jobs.process.stage_sandbox import missing_from_stages
from jobs.queue.enqueue import TRAINING_QUEUE, job_of
from jobs.queue.helper_workflow import HelperWorkflow
from jobs.queue.job_workflow import TrainingWorkflow
from jobs.queue.liveness import open_liveness
from jobs.queue.recovery import Recovery
from jobs.records.announcements import WebhookTable
from jobs.records.job_table import JobTable, metadata
from jobs.records.worker_register import WorkerRegister
from jobs.runs.readiness import Surroundings
from jobs.runs.run_removal import remove_copies
from jobs.webhooks.webhook_delivery import WebhookDelivery
from jobs.webhooks.webhook_rules import WebhookRules

__all__ = ["main", "run_worker", "start_worker"]

# Constant, so that a new release takes over the unfinished workflows of the old one.
# Change it whenever the steps of `train_job` change.
WORKFLOW_VERSION = "jobs-1"
POLL_INTERVAL = 0.5  # seconds between two looks into the queue
ROUND_INTERVAL = 2.0  # seconds between two looks after other workers
TIDY_INTERVAL = 600.0  # seconds between two looks for copies of runs that nobody needs
SAVE_SECONDS = 12.0  # time to bring saved state to the store, where runs lie there
LEAVE_SECONDS = 5.0  # time to hand the running job over at the end
# Connections to Postgres of the job table and DBOS together; the proof of life has another. In one worker of all, DBOS
# keeps one of them: nothing here may hold a connection while it waits for another.
MOST_CONNECTIONS = 2
FENCED = 3  # exit status after losing the proof of life

log = logging.getLogger(__name__)


def run_worker(home: Home, *, exit_with_parent: bool = False) -> NoReturn:
    """Work until SIGTERM or SIGINT, then let the running stage save and leave the rest to another worker.

    One worker runs one job at a time; start one per GPU, or one per machine without.

    Args:
        home: where the queue, the runs and the store are.
        exit_with_parent: also stop when stdin closes, that is when the process that started this one is gone.

    Raises:
        InputError: the home's folder is not the one that its database belongs to.
    """
    keep_secrets()
    guard_imports()
    if lacking := missing_from_stages():
        log.warning("%s", lacking)
    stop = threading.Event()
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, lambda *_: stop.set())
    if exit_with_parent:
        when_parent_is_gone(stop.set)

    engine = create_engine(home, MOST_CONNECTIONS)
    identity = prepare_database(home, engine, metadata)
    queue = open_client(home, engine)
    queue.register_queue(TRAINING_QUEUE, worker_concurrency=1, polling_interval_sec=POLL_INTERVAL)
    stages = StageRunner(home)
    executor = f"{socket.gethostname()}-{os.getpid()}-{secrets.token_hex(4)}"
    liveness = open_liveness(home)
    liveness.hold(executor, on_lost=lambda: _fence(stages))

    dbos = DBOS(
        config={
            "name": APPLICATION,
            "system_database_url": dbos_url(home),
            "system_database_engine": engine,
            "use_listen_notify": False,  # a connection less: nothing here waits for events
            "executor_id": executor,
            "application_version": WORKFLOW_VERSION,
            "serializer": DBOSPortableJSONSerializer(),
            "run_migrations": False,
            "log_level": "WARNING",
        }
    )
    surroundings = Surroundings(home, identity)
    surroundings.watch_store()
    workflow = TrainingWorkflow(home, surroundings, engine, queue, stages)
    workflow.register()
    HelperWorkflow(home, engine, stages, workflow.attended).register()
    table, next_tidying = JobTable(engine), 0.0
    recovery = Recovery(dbos, executor, table, stages, liveness, workflow.attended, surroundings)
    register = WorkerRegister(engine, executor)
    gate = _Gate(dbos)  # closed until the first look has shown whether there is interrupted work to go on with
    WebhookDelivery(WebhookTable(engine), WebhookRules.configured()).start()
    DBOS.listen_queues([TRAINING_QUEUE])
    DBOS.launch()
    log.info("worker %s is ready", executor)

    while not stop.is_set():
        try:
            recovery.give_up_lost()
            recovery.keep_alive()
            refusal = _refusal(surroundings, doubtful=recovery.take_over())
            gate.close_for(refusal)
            recovery.wake()
            recovery.settle()
            if home.runs_in_store and time.monotonic() >= next_tidying:
                next_tidying = time.monotonic() + TIDY_INTERVAL
                remove_copies(home, table.many)
            register.tell(next((job_of(name) for name, _ in list(workflow.attended)), ""), refusal)
        except Exception:
            log.exception("will look after the other workers again in %g s", ROUND_INTERVAL)
        stop.wait(ROUND_INTERVAL)

    gate.close_for("it is being stopped")
    stages.stop()
    deadline = time.monotonic() + GRACE
    while stages.workflows() and time.monotonic() < deadline:
        time.sleep(0.05)
    stages.kill()
    workflow.saving.save_all(SAVE_SECONDS)
    _leave(recovery, register)
    os._exit(0)  # the workflow stays unfinished: now queued, or under this executor's name, for another worker to find


class _Gate:
    """Keeps this worker from taking jobs while there is a reason, as there is at first."""

    def __init__(self, dbos: DBOS) -> None:
        self._running = dbos._active_workflows_set
        self._reason = "starting"
        self._entry: Any = self._occupy()

    def close_for(self, reason: str) -> None:
        """Close for this reason, or open if it is empty."""
        if reason and reason != self._reason:
            log.warning("takes no job: %s", reason)
        self._reason = reason
        if reason and self._entry is None:
            self._entry = self._occupy()
        elif not reason and self._entry is not None:
            self._entry.release()
            self._entry = None

    def _occupy(self) -> Any:
        """Count as one more running workflow, so that DBOS finds this worker busy: it has no other gate."""
        return self._running.add("no workflow", TRAINING_QUEUE)


def _refusal(surroundings: Surroundings, *, doubtful: bool) -> str:
    """Return why this worker must not take a job now; "" if it may."""
    lacking = surroundings.of_machine()
    if lacking is not None:
        return lacking.reason
    return "another worker seems to have died, and its job comes before younger ones" if doubtful else ""


def _leave(recovery: Recovery, register: WorkerRegister) -> None:
    """Hand over the work of this worker, unless the database keeps it waiting."""

    def leave() -> None:
        recovery.leave()
        register.leave()

    thread = threading.Thread(target=leave, daemon=True)
    thread.start()
    thread.join(LEAVE_SECONDS)


def start_worker(home: Home) -> subprocess.Popen[bytes]:
    """Start a worker as a child that stops when this process ends, or when the returned `stdin` is closed."""
    return subprocess.Popen(
        module_command("jobs.worker", "--exit-with-parent"),
        stdin=subprocess.PIPE,
        start_new_session=True,  # Ctrl-C reaches the parent alone, which then ends its workers in order
        env={**os.environ, **home.environment()},
    )


def _fence(stages: StageRunner) -> NoReturn:
    """End at once: another worker may soon take the work over."""
    stages.kill()
    log.error("cannot prove to be alive any more: ending")
    os._exit(FENCED)


def main(arguments: list[str] | None = None) -> None:
    """Run a worker for the home that the environment names."""
    parser = argparse.ArgumentParser(prog="python -m jobs.worker", description="Take jobs from the queue.")
    parser.add_argument("--exit-with-parent", action="store_true", help="stop when stdin closes")
    options = parser.parse_args(arguments)
    logging.basicConfig(level=logging.INFO, format="%(asctime)s %(levelname)s %(name)s: %(message)s")
    try:
        run_worker(Home.from_environment(), exit_with_parent=options.exit_with_parent)
    except InputError as error:
        sys.exit(f"hgs worker: {error}")


if __name__ == "__main__":
    main()
