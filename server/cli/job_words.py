"""Jobs and workers as lines of text, and moments as people type them."""

from __future__ import annotations

import re
import time
from collections.abc import Sequence
from datetime import UTC, datetime
from typing import Any

from hgs_core.base.errors import InputError

__all__ = ["duration", "job_details", "job_table", "no_worker", "seconds_of", "since", "worker_table"]

_UNITS = {"s": 1.0, "m": 60.0, "h": 3600.0, "d": 86400.0}


def seconds_of(text: str, where: str) -> float:
    """Return the seconds of a duration such as 90, 90s, 15m, 12h or 3d.

    Raises:
        InputError: names `where`.
    """
    match = re.fullmatch(r"([0-9]{1,9}(?:\.[0-9]+)?)([smhd]?)", text)
    if match is None:
        raise InputError(where, f"{text!a} is no duration", "give one such as 90s, 15m, 12h or 3d")
    return float(match[1]) * _UNITS[match[2] or "s"]


def since(text: str, where: str) -> float:
    """Return the moment that is so long ago, or that an ISO date names (UTC, if it does not say).

    Raises:
        InputError: names `where`.
    """
    try:
        moment = datetime.fromisoformat(text)
    except ValueError:
        return time.time() - seconds_of(text, where)
    return (moment if moment.tzinfo else moment.replace(tzinfo=UTC)).timestamp()


def duration(seconds: float) -> str:
    """Return a duration in its two largest units."""
    whole = max(0, round(seconds))
    if whole < 60:
        return f"{whole} s"
    if whole < 3600:
        return f"{whole // 60} min"
    if whole < 86400:
        return f"{whole // 3600} h {whole % 3600 // 60} min"
    return f"{whole // 86400} d {whole % 86400 // 3600} h"


def job_table(jobs: Sequence[dict[str, Any]], now: float) -> str:
    """Return jobs as a table, one line each."""
    rows = [("JOB", "STATE", "STAGE", "LEFT", "PRIO", "AGE", "LABELS", "TITLE")]
    rows += [
        (
            job["id"],
            job["state"],
            _stage(job),
            _left(job, now),
            str(job["priority"]),
            duration(now - job["created"]),
            ",".join(job["labels"]) or "-",
            job["title"],
        )
        for job in jobs
    ]
    return _aligned(rows)


def job_details(job: dict[str, Any], now: float) -> str:
    """Return the description of one job, line by line."""
    lines = {
        "job": job["id"],
        "title": job["title"],
        "state": job["state"],
        "waits for": job["waiting"],
        "error": job["error"],
        "stage": _stage(job) if job["stage"] else None,
        "left": _left(job, now) if job["ends"] else None,
        "attempt": job["attempt"],
        "priority": job["priority"],
        "time limit": duration(job["time_limit"]) if job["time_limit"] else None,
        "labels": ", ".join(job["labels"]) or None,
        "capture": job["capture"],
        "preset": job["preset"],
        "sound": sound if (sound := job.get("audio")) != "auto" else None,
        "scene": job["scene"],
        "submitted": f"{duration(now - job['created'])} ago",
        "last word": f"{duration(now - job['updated'])} ago",
    }
    return "\n".join(f"{name:<11} {value}" for name, value in lines.items() if value is not None)


def no_worker(jobs: Sequence[dict[str, Any]], workers: Sequence[Any], server: str = "") -> str:
    """Return the line for jobs that are queued where nobody takes them, on this machine or on a `server`; else ""."""
    if workers or all(job["state"] != "queued" for job in jobs):
        return ""
    return f"queued; no worker is running{f' at {server}' if server else ''}: start one with hgs worker, or hgs serve"


def worker_table(workers: Sequence[dict[str, Any]], now: float) -> str:
    """Return workers as a table, one line each."""
    rows = [("WORKER", "HOST", "DEVICE", "JOB", "UP", "WHY IDLE")]
    rows += [
        (
            one["id"],
            one["host"],
            one["device"] or "-",
            one["job"] or "-",
            duration(now - one["started"]),
            one["idle_because"] or "-",
        )
        for one in workers
    ]
    return _aligned(rows)


def _stage(job: dict[str, Any]) -> str:
    progress = job["progress"]
    if progress is None:
        return "-"
    return f"{progress['stage']} {progress['done']}/{progress['total']}"


def _left(job: dict[str, Any], now: float) -> str:
    return duration(job["ends"] - now) if job["ends"] else "-"


def _aligned(rows: Sequence[tuple[str, ...]]) -> str:
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    return "\n".join("  ".join(map(str.ljust, row, widths)).rstrip() for row in rows)
