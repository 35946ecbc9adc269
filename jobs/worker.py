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
from typing import NoReturn

from dbos import DBOS, DBOSPortableJSONSerializer

from jobs.client import TRAINING_QUEUE, workflow_id
from jobs.database import APPLICATION, create_engine, open_client, prepare_database
from jobs.home import Home
from jobs.liveness import Liveness, open_liveness
from jobs.store import JobTable, metadata
from jobs.subprocesses import GRACE, StageRunner
from jobs.workflows import MAX_TAKE_OVERS, register_workflows

__all__ = ["main", "run_worker", "start_worker"]

# Constant, so that a new release takes over the unfinished workflows of the old one.
# Change it whenever the steps of `train_job` change.
WORKFLOW_VERSION = "jobs-1"
POLL_INTERVAL = 0.5  # seconds between two looks into the queue
ROUND_INTERVAL = 2.0  # seconds between two looks after other workers
FENCED = 3  # exit status after losing the proof of life

log = logging.getLogger(__name__)


def run_worker(home: Home, *, exit_with_parent: bool = False) -> NoReturn:
    """Work until SIGTERM or SIGINT, then let the running stage save and leave the rest to another worker.

    One worker runs one job at a time; start one per GPU, or one per machine without.

    Args:
        home: where the queue, the runs and the store are.
        exit_with_parent: also stop when stdin closes, that is when the process that started this one is gone.
    """
    stop = threading.Event()
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, lambda *_: stop.set())
    if exit_with_parent:
        threading.Thread(target=_await_end_of_stdin, args=(stop,), daemon=True).start()

    engine = create_engine(home)
    prepare_database(home, engine, metadata)
    queue = open_client(home, engine)
    queue.register_queue(TRAINING_QUEUE, worker_concurrency=1, polling_interval_sec=POLL_INTERVAL)
    queue.destroy()
    table = JobTable(engine)
    stages = StageRunner(home)
    executor = f"{socket.gethostname()}-{os.getpid()}-{secrets.token_hex(4)}"
    liveness = open_liveness(home)
    liveness.hold(executor, on_lost=lambda: _fence(stages))

    DBOS(
        config={
            "name": APPLICATION,
            "system_database_url": home.database_url,
            "system_database_engine": engine if engine.dialect.name == "sqlite" else None,
            "executor_id": executor,
            "application_version": WORKFLOW_VERSION,
            "serializer": DBOSPortableJSONSerializer(),
            "run_migrations": False,
            "log_level": "WARNING",
        }
    )
    register_workflows(home, table, stages)
    DBOS.listen_queues([TRAINING_QUEUE])
    DBOS.launch()
    log.info("worker %s is ready", executor)

    while not stop.is_set():
        try:
            _give_up_lost(stages, executor)
            _take_over_dead(liveness, executor)
            _settle(table)
        except Exception:
            log.exception("will look after the other workers again in %g s", ROUND_INTERVAL)
        stop.wait(ROUND_INTERVAL)

    stages.stop()
    deadline = time.monotonic() + GRACE
    while stages.workflows() and time.monotonic() < deadline:
        time.sleep(0.05)
    stages.kill()
    os._exit(0)  # the workflow stays unfinished under this executor's name, for another worker to find


def start_worker(home: Home) -> subprocess.Popen[bytes]:
    """Start a worker as a child that stops when this process ends, or when the returned `stdin` is closed."""
    return subprocess.Popen(
        [sys.executable, "-m", "jobs.worker", "--exit-with-parent"],
        stdin=subprocess.PIPE,
        start_new_session=True,  # Ctrl-C reaches the parent alone, which then ends its workers in order
        env={**os.environ, **home.environment()},
    )


def _give_up_lost(stages: StageRunner, executor: str) -> None:
    """Kill the stages of workflows that another worker has taken over."""
    running = stages.workflows()  # before the query: what was started later is not judged by older news
    if running:
        for workflow in DBOS.list_workflows(workflow_ids=running, load_input=False, load_output=False):
            ours = workflow.status == "PENDING" and workflow.executor_id == executor
            if workflow.status in ("PENDING", "ENQUEUED") and not ours:
                log.warning("%s now belongs to another worker", workflow.workflow_id)
                stages.abandon(workflow.workflow_id)


def _take_over_dead(liveness: Liveness, executor: str) -> None:
    """Queue the unfinished workflows of dead workers again."""
    unfinished = DBOS.list_workflows(status="PENDING", load_input=False, load_output=False)
    for other in {workflow.executor_id for workflow in unfinished if workflow.executor_id} - {executor}:
        with liveness.claim_dead(other) as dead:
            if dead:
                recovered = DBOS._recover_pending_workflows([other])
                log.warning("worker %s is dead; queued %d of its workflows again", other, len(recovered))


def _settle(table: JobTable) -> None:
    """Bring in line the rows of jobs whose workflow ended without a word, because its process died at that moment."""
    jobs = {workflow_id(job.id, job.attempt): job for job in table.active()}
    if not jobs:
        return
    for workflow in DBOS.list_workflows(workflow_ids=list(jobs), load_input=False):
        job = jobs[workflow.workflow_id]
        if workflow.status == "CANCELLED":
            table.cancel(job.id, job.attempt)
        elif workflow.status == "ERROR":
            table.fail(job.id, job.attempt, f"internal error: {workflow.error}")
        elif workflow.status == "MAX_RECOVERY_ATTEMPTS_EXCEEDED":
            table.fail(job.id, job.attempt, f"given up: {MAX_TAKE_OVERS} workers died while they ran this job")


def _fence(stages: StageRunner) -> NoReturn:
    """End at once: another worker may soon take the work over."""
    stages.kill()
    log.error("cannot prove to be alive any more: ending")
    os._exit(FENCED)


def _await_end_of_stdin(stop: threading.Event) -> None:
    while os.read(0, 4096):
        pass
    stop.set()


def main(arguments: list[str] | None = None) -> None:
    """Run a worker for the home that the environment names."""
    parser = argparse.ArgumentParser(prog="python -m jobs.worker", description="Take jobs from the queue.")
    parser.add_argument("--exit-with-parent", action="store_true", help="stop when stdin closes")
    options = parser.parse_args(arguments)
    logging.basicConfig(level=logging.INFO, format="%(asctime)s %(levelname)s %(name)s: %(message)s")
    run_worker(Home.from_environment(), exit_with_parent=options.exit_with_parent)


if __name__ == "__main__":
    main()
