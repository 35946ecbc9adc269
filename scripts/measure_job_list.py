"""Measures how long the list of jobs takes when there are many.

.venv/bin/python -m scripts.measure_job_list [JOBS] [DATABASE_URL]
"""

from __future__ import annotations

import dataclasses
import random
import statistics
import sys
import tempfile
import time
from pathlib import Path

import sqlalchemy as sa

from hgs_core.runs.run_config import RunConfig
from jobs.home.home import Home
from jobs.queue.client import JobClient
from jobs.records.job import Job, JobState, Place
from jobs.records.job_filter import JobFilter
from jobs.records.job_schema import job_labels, job_rows

TIMES = 15


def fill(client: JobClient, count: int) -> None:
    """Add jobs with full configs: 4 running, a tenth queued, the rest finished; 50 captures, 100 labels."""
    chance = random.Random(0)
    config = RunConfig().to_json()
    now = time.time()
    rows, labels = [], []
    for number in range(count):
        state = JobState.RUNNING if number < 4 else JobState.QUEUED if number % 10 == 0 else JobState.SUCCEEDED
        if number % 25 == 3 and number > 4:
            state = JobState.FAILED
        mine = tuple(sorted({f"client-{chance.randrange(90)}", f"batch-{chance.randrange(10)}"}))
        job = Job(
            f"take-{number:05}-{chance.randrange(1 << 32):08x}",
            f"Take {number} of the {chance.choice('ABC')} stage",
            f"/captures/{number % 50}",
            config,
            state,
            labels=mine,
            figures={"psnr": 27.1, "loss": 0.01},
        )
        rows.append({**job.to_json(), "created": now - number * 60, "updated": now - number * 60 + 30})
        labels += [{"label": label, "job_id": job.id} for label in mine]
    with client._engine.begin() as connection:
        connection.execute(sa.insert(job_rows), rows)
        connection.execute(sa.insert(job_labels), labels)


def main() -> None:
    """Fill a database, and print the median and the longest time of each question."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 10_000
    with tempfile.TemporaryDirectory() as folder:
        home = Home.at(Path(folder))
        if len(sys.argv) > 2:
            home = dataclasses.replace(home, database_url=sys.argv[2])
        with JobClient(home) as client:
            fill(client, count)
            middle = client.list(1000)[-1]
            now = time.time()
            questions = {
                "first page": lambda: client.list(101),
                "page after 1000 jobs": lambda: client.list(101, after=Place.of(middle)),
                "state=running": lambda: client.list(101, JobState.RUNNING),
                "state=failed": lambda: client.list(101, JobState.FAILED),
                "one label": lambda: client.list(101, wanted=JobFilter(labels=("client-7",))),
                "two labels": lambda: client.list(101, wanted=JobFilter(labels=("client-7", "batch-3"))),
                "a capture": lambda: client.list(101, wanted=JobFilter(capture="/captures/7")),
                "a day": lambda: client.list(101, wanted=JobFilter(since=now - 2 * 86400, until=now - 86400)),
                "find a title": lambda: client.list(101, wanted=JobFilter(words=f"take {count - 7} of")),
                "find nothing": lambda: client.list(101, wanted=JobFilter(words="nowhere")),
                "jobs ahead": lambda: client.ahead_of(client.list(1, JobState.QUEUED)[0]),
            }
            print(f"{count} jobs, {home.database_url.partition(':')[0]}; ms, median and longest of {TIMES}")
            for name, ask in questions.items():
                times = []
                for _ in range(TIMES):
                    began = time.perf_counter()
                    ask()
                    times.append(1000 * (time.perf_counter() - began))
                print(f"{name:<22} {statistics.median(times):6.1f} {max(times):6.1f}")


if __name__ == "__main__":
    main()
