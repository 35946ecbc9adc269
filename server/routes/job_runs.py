"""`/v1/jobs/{id}/…`: views of a job's run folder: history, log, picture and report."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from fastapi import APIRouter, Request, Response

from hgs_core.runs.run_folder import RunFolder
from jobs.records.job import Job, JobState
from jobs.runs.progress_log import read_course, thinned
from server.http.conditional import entity_tag, respond, respond_compressed, respond_json
from server.http.encodable import encodable
from server.http.problems import ProblemError
from server.http.security_headers import REPORT_POLICY
from server.job_views.job_log import MOST_LOG_LINES, log_tail
from server.service import Service, ServiceDep

__all__ = ["router"]

router = APIRouter(prefix="/v1/jobs/{job_id}")

_MILESTONES = 1000
_LINES = 100  # log lines by default
_LARGEST_PICTURE = 4 << 20  # bytes; a picture of 480 pixels' width has some ten thousand
_LARGEST_REPORT = 64 << 20


@router.api_route("/run", methods=["GET", "HEAD"])
def run(request: Request, job_id: str, service: ServiceDep) -> Response:
    """Describe a job's queue position, webhook, picture, report and scene."""
    job = service.known_job(job_id)
    folder = service.runs.folder(job_id)
    picture = _picture(folder)
    answer = {
        "ahead": service.jobs.ahead_of(job) if job.state is JobState.QUEUED else None,
        "announcement": _announcement(service, job),
        "picture": None if picture is None else str(picture.stat().st_mtime_ns),
        "report": (folder / "report.html").is_file(),
        "scene": _scene(service, job),
    }
    return respond_json(request, answer)


@router.api_route("/history", methods=["GET", "HEAD"])
def history(request: Request, job_id: str, service: ServiceDep) -> Response:
    """Return the history of a job: the progress and figures of its stages."""
    service.known_job(job_id)
    course = thinned(read_course(service.runs.folder(job_id)), _MILESTONES)
    points = [
        {
            "attempt": one.attempt,
            "stage": one.stage,
            "done": one.done,
            "total": one.total,
            "time": one.time,
            "figures": dict(one.figures),
        }
        for one in course
    ]
    return respond_json(request, encodable({"points": points}))


@router.api_route("/log", methods=["GET", "HEAD"])
def log(request: Request, job_id: str, service: ServiceDep) -> Response:
    """Return the end of a job's log."""
    service.known_job(job_id)
    count = _line_count(request.query_params.multi_items())
    return respond_json(request, log_tail(service.runs.folder(job_id), count))


@router.api_route("/picture", methods=["GET", "HEAD"])
def picture(request: Request, job_id: str, service: ServiceDep) -> Response:
    """Serve the last picture of a job."""
    service.known_job(job_id)
    file = _picture(service.runs.folder(job_id))
    body = None if file is None else _whole(file, _LARGEST_PICTURE)
    if body is None:
        raise ProblemError(404, "picture-not-found", f"job {job_id}: has no picture yet")
    return respond(request, body, "image/jpeg", etag=entity_tag(body), cache_control="no-cache")


@router.api_route("/report", methods=["GET", "HEAD"])
def report(request: Request, job_id: str, service: ServiceDep) -> Response:
    """Serve the report of a job's run, restricted to its own pictures and script."""
    service.known_job(job_id)
    body = _whole(service.runs.folder(job_id) / "report.html", _LARGEST_REPORT)
    if body is None:
        cure = "" if service.home.runs_in_store else f"; write one with hgs report {service.home.run(job_id)}"
        detail = f"job {job_id}: has no report{cure}"
        raise ProblemError(404, "report-not-found", detail)
    response = respond_compressed(request, body, "text/html; charset=utf-8")
    response.headers["Content-Security-Policy"] = REPORT_POLICY
    return response


def _picture(run: Path) -> Path | None:
    """Return the thumbnail of an encoded scene, or else the last picture of its training, or None."""
    folder = RunFolder(run)
    return next((file for file in (folder.thumbnail, folder.preview) if file.is_file()), None)


def _announcement(service: Service, job: Job) -> dict[str, Any] | None:
    told = service.jobs.announcement(job.id) if job.webhook else None
    if told is None:
        return None
    state = "delivered" if told.delivered else "waiting" if told.next_try is not None else "given-up"
    return {"state": state, "attempt": told.attempt, "tries": told.tries, "error": told.error or None}


def _scene(service: Service, job: Job) -> str | None:
    """Return the job's scene while it is published; a growing one is published before the job ends."""
    scene_id = job.scene_id or job.id
    return None if service.artifacts.scene_entry(scene_id) is None else scene_id


def _whole(file: Path, most_bytes: int) -> bytes | None:
    """Return a file's bytes, or None if it does not exist."""
    try:
        with file.open("rb") as opened:
            body = opened.read(most_bytes + 1)
    except FileNotFoundError:
        return None
    if len(body) > most_bytes:
        raise ProblemError(500, "internal", f"{file.name} is larger than {most_bytes >> 20} MiB")
    return body


def _line_count(parameters: list[tuple[str, str]]) -> int:
    for name, _ in parameters:
        if name != "lines":
            detail = f"unknown parameter {name[:40]!a}; the only one is lines"
            raise ProblemError(422, "query-invalid", detail, field=name)
    if len(parameters) > 1:
        raise ProblemError(422, "query-invalid", "lines: given twice", field="lines")
    text = parameters[0][1] if parameters else str(_LINES)
    if not re.fullmatch("[1-9][0-9]{0,3}", text) or int(text) > MOST_LOG_LINES:
        detail = f"lines: {text[:40]!a} is not a number of lines; give 1 to {MOST_LOG_LINES}"
        raise ProblemError(422, "query-invalid", detail, field="lines")
    return int(text)
